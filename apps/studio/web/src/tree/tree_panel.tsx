// The scene panel: tools for adding, a search, the tree.
import type { JSX } from "preact";
import { insert, kTools } from "../add/commands";
import type { Studio } from "../core/studio";
import { Icon } from "./icons";
import { openInsertMenu } from "./menu";
import { TreeModel } from "./tree_model";
import { TreeState } from "./tree_state";
import { TreeView } from "./view";

function Tools({ studio }: { studio: Studio }): JSX.Element | null {
  const ready = studio.state.mayEdit.value && studio.services.get(TreeState).schema.value !== null;
  if (studio.state.hello.value?.kind !== "scene") return null;
  return (
    <div class="cg-tools cg-tree-tools" role="toolbar" aria-label="Insert">
      {kTools.map(({ title, tags }) => (
        <span key={title} role="group" aria-label={title}>
          {tags.map((tag) => (
            <button
              key={tag}
              type="button"
              class="cg-tool"
              aria-label={`Insert ${tag}`}
              title={`Insert ${tag} (Alt: set its attributes first)`}
              disabled={!ready}
              onClick={(event) => void insert(studio, tag, event.altKey)}
            >
              <Icon tag={tag} />
            </button>
          ))}
        </span>
      ))}
      <button
        type="button"
        class="cg-tool"
        aria-haspopup="menu"
        disabled={!ready}
        onClick={(event) => {
          const rect = event.currentTarget.getBoundingClientRect();
          openInsertMenu(studio, rect.left, rect.bottom);
        }}
      >
        Insert…
      </button>
    </div>
  );
}

export function TreePanel({ studio }: { studio: Studio }): JSX.Element {
  const model = studio.services.get(TreeModel);
  const count = studio.state.tree.value.elements.length;
  const found = model.search.value === "" ? 0 : model.rows.value.filter((r) => r.found).length;
  return (
    <div class="cg-tree-all">
      <Tools studio={studio} />
      <div class="cg-tree-search">
        <input
          type="search"
          aria-label="Search the scene"
          placeholder="Search name, kind, value"
          value={model.search.value}
          spellcheck={false}
          onInput={(event) => (model.search.value = event.currentTarget.value)}
          onKeyDown={(event) => {
            if (event.key === "Escape") model.search.value = "";
            else if (event.key === "Enter") {
              const ids = model.rows
                .peek()
                .filter((r) => r.found && !r.signal)
                .map((r) => r.id);
              if (ids.length > 0) studio.select([ids[0]!]);
            } else if (event.key === "ArrowDown") {
              event.currentTarget.closest(".cg-tree-all")?.querySelector<HTMLElement>('[role="tree"]')?.focus();
            } else return;
            event.stopPropagation();
          }}
        />
        <span class="cg-muted" role="status">
          {model.search.value === "" ? "" : `${found} found`}
        </span>
      </div>
      {count === 0 ? <p class="cg-muted cg-tree-empty">Nothing was read from the file.</p> : <TreeView model={model} />}
    </div>
  );
}
