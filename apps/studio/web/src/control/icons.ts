/** Outlines in a square of 16. */
export const icons = {
  play: "M4 2.5v11l9-5.5z",
  pause: "M3.5 2.5h3v11h-3zM9.5 2.5h3v11h-3z",
  stop: "M3 3h10v10H3z",
  restart: "M8 3V.5L3.8 4 8 7.5V5a4 4 0 1 1-4 4H2a6 6 0 1 0 6-6z",
  back: "M11 2.5v11L5 8zM2.5 2.5h2v11h-2z",
  step: "M5 2.5v11L11 8zM11.5 2.5h2v11h-2z",
  slower: "M2.5 7h11v2h-11z",
  faster: "M7 2.5h2V7h4.5v2H9v4.5H7V9H2.5V7H7z",
  record: "M8 3a5 5 0 1 0 0 10A5 5 0 0 0 8 3z",
  previous: "M10.5 2.5v11L3 8zM11 3h2v10h-2z",
  next: "M5.5 2.5v11L13 8zM3 3h2v10H3z",
};
export type IconName = keyof typeof icons;
