// What loader and viewer of a bundle's page share.
declare global {
  /** The run, unpacked, on its way from the loader to the viewer. */
  var cogrsim_bundle: ArrayBuffer | undefined;
}

/** Of the element that says how far it is. */
export const kWaitId = "cg-unpacking";
