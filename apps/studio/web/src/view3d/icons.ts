/** Of the tools over the picture: lines in a square of 16. */
export const icons = {
  home: "M2 8 8 2.500 14 8M4 7v6.500h8V7",
  fit: "M2 5.500V2h3.500M10.500 2H14v3.500M14 10.500V14h-3.500M5.500 14H2v-3.500M5.500 5.500h5v5h-5Z",
  focus: "M8 1.500v3M8 11.500v3M1.500 8h3M11.500 8h3M11.500 8a3.500 3.500 0 1 1-7 0 3.500 3.500 0 0 1 7 0Z",
  follow: "M1.500 11 8 2.500 14.500 11M4 14.500 8 9.500l4 5",
  flat: "M2.500 5.500h8v8h-8ZM2.500 5.500l3-3h8l-3 3M13.500 2.500v8l-3 3",
  move: "M8 1.500v13M1.500 8h13M8 1.500 6 3.500M8 1.500l2 2M8 14.500l-2-2M8 14.500l2-2M1.500 8l2-2M1.500 8l2 2M14.500 8l-2-2M14.500 8l-2 2",
  rotate: "M13.500 8a5.500 5.500 0 1 1-2-4.200M12 1v3.200H8.800",
  resize: "M2 9v5h5M14 7V2H9M2 14l4.500-4.500M14 2 9.500 6.500",
  grab: "M8 1.500v3M5 4.500h6v3a3 3 0 0 1-6 0ZM8 10.500l-2 1 4 1-4 1 2 1",
  local: "M4 12V3M4 12h9M4 12l4.500-4.500M4 3 2.700 4.800M4 3l1.300 1.800M13 12l-1.800-1.300M13 12l-1.800 1.300",
  snap: "M3 2v6a5 5 0 0 0 10 0V2h-3v6a2 2 0 0 1-4 0V2ZM3 5h3M10 5h3",
  show: "M1 8c3.500-6 10.500-6 14 0-3.500 6-10.500 6-14 0ZM10 8a2 2 0 1 1-4 0 2 2 0 0 1 4 0Z",
};
export type IconName = keyof typeof icons;

export function iconOf(document: Document, name: IconName): SVGSVGElement {
  const make = <K extends "svg" | "path">(tag: K) => document.createElementNS("http://www.w3.org/2000/svg", tag);
  const svg = make("svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  const path = make("path");
  path.setAttribute("d", icons[name]);
  svg.append(path);
  return svg;
}
