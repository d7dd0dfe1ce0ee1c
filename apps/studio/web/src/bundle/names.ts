// What loader and viewer of a bundle's page share.
declare global {
  /** The unpacked run, from the loader to the viewer. */
  var cogrsim_bundle: ArrayBuffer | undefined;
}

/** The id of the element that shows the progress. */
export const kWaitId = "cg-unpacking";
