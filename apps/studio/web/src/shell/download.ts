/** Puts a file into the browser's downloads. */
export function download(file: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(file);
  link.download = name;
  link.click();
  // the browser takes the file up in its own time
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
