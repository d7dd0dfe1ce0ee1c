// As much of Plotly as is used; both partial bundles are alike.
interface PlotlyBundle {
  react(host: HTMLElement, traces: object[], layout: object, config?: object): Promise<unknown>;
  purge(host: HTMLElement): void;
  toImage(
    figure: { data: object[]; layout: object },
    options: { format: "png"; width: number; height: number; scale: number },
  ): Promise<string>;
  Plots: { resize(host: HTMLElement): Promise<unknown> };
}
declare module "plotly.js-cartesian-dist-min" {
  const plotly: PlotlyBundle;
  export default plotly;
}
declare module "plotly.js-gl3d-dist-min" {
  const plotly: PlotlyBundle;
  export default plotly;
}
