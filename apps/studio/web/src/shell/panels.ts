// All panels there are.
import * as cameras from "../cameras/panel";
import * as code from "../code/panel";
import * as compare from "../compare/panel";
import * as consolePanel from "../console/panel";
import type { PanelType, Studio } from "../core/studio";
import * as debug from "../debug/panel";
import * as figures from "../figures/panel";
import * as forms from "../forms/panel";
import * as hands from "../hands/panel";
import * as map2d from "../map2d/panel";
import * as sceneTests from "../scene_tests/panel";
import * as tree from "../tree/panel";
import * as view3d from "../view3d/panel";

/** In the order of the View menu. */
export const panels: { panel: PanelType; register(studio: Studio): void }[] = [
  view3d,
  map2d,
  tree,
  forms,
  hands,
  code,
  cameras,
  figures,
  compare,
  sceneTests,
  debug,
  consolePanel,
];

export function panelNamed(name: string): PanelType | undefined {
  return panels.find((p) => p.panel.name === name)?.panel;
}
