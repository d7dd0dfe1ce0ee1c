// Who is called when a link has something new.
import type { Frame, Picture } from "./frame";
import type { Unsubscribe } from "./link";
import type { Topics } from "./protocol";

type Listener<T> = (value: T) => void;

/** A set of listeners; one that fails does not keep the others from being called. */
export class Listeners<T> {
  private readonly all = new Set<Listener<T>>();

  add(listener: Listener<T>): Unsubscribe {
    this.all.add(listener);
    return () => void this.all.delete(listener);
  }
  publish(value: T): void {
    for (const listener of [...this.all]) {
      try {
        listener(value);
      } catch (error) {
        console.error(error);
      }
    }
  }
}

/** The listeners of a link. */
export class LinkListeners {
  protected readonly frames = new Listeners<Frame>();
  protected readonly pictures = new Listeners<Picture>();
  private readonly topics = new Map<keyof Topics, Listeners<unknown>>();

  on<Name extends keyof Topics>(name: Name, listener: (message: Topics[Name]) => void): Unsubscribe {
    let listeners = this.topics.get(name);
    if (!listeners) this.topics.set(name, (listeners = new Listeners()));
    return listeners.add(listener as Listener<unknown>);
  }
  onFrame(listener: (frame: Frame) => void): Unsubscribe {
    return this.frames.add(listener);
  }
  onPicture(listener: (picture: Picture) => void): Unsubscribe {
    return this.pictures.add(listener);
  }

  protected publish<Name extends keyof Topics>(name: Name, message: Topics[Name]): void {
    this.topics.get(name)?.publish(message);
  }
}

/** Calls `then` before the browser draws next; without a browser, soon. */
export function nextPicture(then: () => void): void {
  if (typeof requestAnimationFrame === "function" && !document.hidden) requestAnimationFrame(then);
  else setTimeout(then, 16);
}
