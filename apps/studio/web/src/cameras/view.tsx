// The list of cameras, and the windows that float over the page.
import { useSignal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import type { JSX } from "preact";
import { kPictureKinds, type Camera, type CameraStore, type PictureKind } from "./store";
import type { Rect } from "./windows";

function KindChoice({ store, name }: { store: CameraStore; name: string }): JSX.Element {
  return (
    <select
      aria-label={`What camera ${name} shows`}
      value={store.stateOf(name).kind}
      onChange={(event) => store.choose(name, event.currentTarget.value as PictureKind)}
    >
      {kPictureKinds.map(({ kind, label }) => (
        <option key={kind} value={kind}>
          {label}
        </option>
      ))}
    </select>
  );
}

/** Content of the panel. */
export function CameraList({ store }: { store: CameraStore }): JSX.Element {
  const cameras = store.cameras.value;
  const names = cameras.map((c) => c.name);
  if (cameras.length === 0)
    return (
      <p class="cg-cameras-none cg-muted">
        There is no camera in this scene. Add a camera to a body, or save a view, and it is listed here.
      </p>
    );
  const group = (title: string, list: Camera[]): JSX.Element | null =>
    list.length === 0 ? null : (
      <section aria-label={title}>
        <h3>{title}</h3>
        <ul>
          {list.map(({ name, element }) => (
            <li key={name}>
              <label>
                <input
                  type="checkbox"
                  role="switch"
                  checked={store.stateOf(name).shown}
                  onChange={(event) => {
                    store.show([name], event.currentTarget.checked);
                    if (element >= 0) store.studio.select([element]);
                  }}
                />
                <span>{name}</span>
              </label>
              <KindChoice store={store} name={name} />
            </li>
          ))}
        </ul>
      </section>
    );
  return (
    <div class="cg-cameras-list">
      <div class="cg-tools" role="toolbar" aria-label="Cameras">
        <button type="button" onClick={() => store.show(names, true)}>
          Show all
        </button>
        <button type="button" disabled={store.open.value.length === 0} onClick={() => store.show(names, false)}>
          Hide all
        </button>
        <span class="cg-muted">
          {store.open.value.length} of {cameras.length} shown
        </span>
      </div>
      {store.refusal.value && (
        <p class="cg-error" role="alert">
          No pictures: {store.refusal.value}
        </p>
      )}
      {group(
        "Sensors",
        cameras.filter((c) => c.from === "sensor"),
      )}
      {group(
        "Saved views",
        cameras.filter((c) => c.from === "view"),
      )}
    </div>
  );
}

/** All windows, over the page. */
export function CameraWindows({ store }: { store: CameraStore }): JSX.Element {
  return (
    <>
      {store.open.value.map(({ name }) => (
        <CameraWindow key={name} store={store} name={name} />
      ))}
    </>
  );
}

const kArrows: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

function CameraWindow({ store, name }: { store: CameraStore; name: string }): JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null);
  const time = useSignal<number | null>(null);
  const size = useSignal("");
  const { kind, rect } = store.stateOf(name);
  const kindLabel = kPictureKinds.find((k) => k.kind === kind)!.label;

  // at once: of a run that stands still there comes one picture only
  useLayoutEffect(() => {
    let gone = false;
    // pictures may be decoded out of turn: an older one must not follow a newer one
    let newest = 0;
    let drawn = 0;
    const stop = store.studio.link.onPicture((picture) => {
      if (picture.name !== name || picture.kind !== store.stateOf(name).kind) return;
      const number = ++newest;
      createImageBitmap(picture.file).then(
        (image) => {
          const to = canvas.current;
          if (!gone && to && number > drawn) {
            drawn = number;
            to.width = image.width;
            to.height = image.height;
            to.getContext("2d")?.drawImage(image, 0, 0);
            time.value = picture.time;
            size.value = `${picture.width} × ${picture.height}`;
          }
          image.close();
        },
        () => store.studio.notify(`the picture of camera ${name} cannot be read`, "error"),
      );
    });
    return () => {
      gone = true;
      stop();
    };
  }, [name]);
  // another kind: what is there is no longer what the window says
  useLayoutEffect(() => void (time.value = null), [kind]);

  if (!rect) return <></>;
  const drag = (event: PointerEvent, change: (from: Rect, dx: number, dy: number) => Rect): void => {
    if (event.button !== 0 || (event.target as Element).closest("button, select")) return;
    const handle = event.currentTarget as HTMLElement;
    const from = store.stateOf(name).rect ?? rect;
    const [x0, y0] = [event.clientX, event.clientY];
    const move = (e: PointerEvent): void => store.put(name, change(from, e.clientX - x0, e.clientY - y0));
    const end = (): void => {
      handle.removeEventListener("pointermove", move);
      handle.removeEventListener("pointerup", end);
      handle.removeEventListener("pointercancel", end);
    };
    handle.setPointerCapture(event.pointerId);
    handle.addEventListener("pointermove", move);
    handle.addEventListener("pointerup", end);
    handle.addEventListener("pointercancel", end);
  };
  const keys = (event: KeyboardEvent): void => {
    if (event.target !== event.currentTarget || event.ctrlKey || event.altKey || event.metaKey) return;
    const arrow = kArrows[event.key];
    if (arrow) {
      const [dx, dy] = [16 * arrow[0], 16 * arrow[1]];
      store.put(
        name,
        event.shiftKey
          ? { ...rect, width: rect.width + dx, height: rect.height + dy }
          : { ...rect, x: rect.x + dx, y: rect.y + dy },
      );
    } else if (event.key === "Escape" || event.key === "Delete") {
      store.show([name], false);
    } else {
      return;
    }
    // these keys also step the run and delete things
    event.preventDefault();
    event.stopPropagation();
  };
  const raise = (): void => store.raise(name);
  const when = time.value === null ? "" : `${time.value.toFixed(3)} s`;
  const bundle = store.studio.state.hello.value?.kind === "bundle";
  const noneYet = bundle ? "no such picture came with this run up to here" : "waiting for a picture";
  return (
    <section
      class="cg-camera"
      role="dialog"
      aria-label={`Camera ${name}`}
      data-testid={`camera-${name}`}
      style={{
        left: `${rect.x}px`,
        top: `${rect.y}px`,
        width: `${rect.width}px`,
        height: `${rect.height}px`,
        zIndex: 1 + store.order.value.indexOf(name),
      }}
      onPointerDown={raise}
      onFocusIn={raise}
    >
      <header
        class="cg-camera-bar"
        tabIndex={0}
        role="group"
        aria-label={`Position of camera ${name}`}
        title="Arrow keys move the window, with Shift they change its size, Escape hides it"
        onPointerDown={(e) => drag(e, (from, dx, dy) => ({ ...from, x: from.x + dx, y: from.y + dy }))}
        onKeyDown={keys}
      >
        <strong>{name}</strong>
        <KindChoice store={store} name={name} />
        <button type="button" aria-label={`Hide camera ${name}`} onClick={() => store.show([name], false)}>
          ✕
        </button>
      </header>
      <div class="cg-camera-picture">
        <canvas
          ref={canvas}
          role="img"
          aria-label={`${kindLabel} picture of camera ${name}${when ? ` at ${when}` : ", none yet"}`}
          hidden={time.value === null}
        />
        {time.value === null && <span class="cg-muted">{store.refusal.value || noneYet}</span>}
      </div>
      <div class="cg-camera-foot">
        <span>{when}</span>
        <span>{time.value === null ? "" : size.value}</span>
      </div>
      <div
        class="cg-camera-corner"
        aria-hidden="true"
        onPointerDown={(e) =>
          drag(e, (from, dx, dy) => ({ ...from, width: from.width + dx, height: from.height + dy }))
        }
      />
    </section>
  );
}
