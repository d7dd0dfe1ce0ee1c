// The connection to a server: one WebSocket, opened again whenever it breaks.
import { decode_frame, decode_picture } from "./decode";
import { RequestError, type Link, type Unsubscribe } from "./link";
import { Listeners, next_picture } from "./memory_link";
import type { Failure, Frame, Picture, Topics } from "./protocol";

/** As much of a WebSocket as is needed; tests bring their own. */
export interface Socket {
  binaryType: string;
  readyState: number;
  onopen: (() => void) | null;
  onclose: (() => void) | null;
  onmessage: ((message: { data: unknown }) => void) | null;
  send(text: string): void;
  close(): void;
}

export interface SocketLinkOptions {
  /** what lets the page in */
  key?: string;
  connect?: () => Socket;
  /** Calls back before the next picture is drawn. */
  next_picture?: (then: () => void) => void;
}

interface Waiting {
  resolve(answer: unknown): void;
  reject(error: Error): void;
  timer: ReturnType<typeof setTimeout>;
}

const kOpen = 1;
/** [ms] Engines may take long to load a scene, compilers longer. */
const kPatience = 60_000;
const kPatienceOf: Record<string, number> = { build: 3_600_000 };
/** [ms] */
const kFirstDelay = 250;
const kLongestDelay = 5_000;

/** Requests that are repeated on a new connection, the last of each. */
const kStanding = ["subscribe", "cameras"];

export class SocketLink implements Link {
  private socket: Socket | null = null;
  private is_open = false;
  private delay = kFirstDelay;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private next_id = 1;
  private readonly waiting = new Map<number, Waiting>();
  private readonly standing = new Map<string, Record<string, unknown>>();
  /** the newest that has not been handed out */
  private newest: Frame | null = null;
  private readonly frames = new Listeners<Frame>();
  private readonly pictures = new Listeners<Picture>();
  private readonly opens = new Listeners<boolean>();
  private readonly topics = new Map<string, Listeners<unknown>>();
  private readonly connect: () => Socket;
  private readonly next_picture: (then: () => void) => void;
  /** what addresses of textures begin with */
  private assets = "";

  constructor(options: SocketLinkOptions = {}) {
    const { key = "" } = options;
    this.connect = options.connect ?? (() => connect_here(key));
    this.next_picture = options.next_picture ?? next_picture;
    this.open();
    if (typeof window !== "undefined") {
      window.addEventListener("online", () => this.try_now());
      document.addEventListener("visibilitychange", () => {
        if (!document.hidden) this.try_now();
      });
    }
  }

  request<Answer = Record<string, unknown>>(what: string, fields: Record<string, unknown> = {}): Promise<Answer> {
    if (kStanding.includes(what)) this.standing.set(what, fields);
    const socket = this.socket;
    if (!socket || !this.is_open) {
      return Promise.reject(new RequestError({ message: "there is no connection to the studio", code: "closed" }));
    }
    return new Promise((resolve, reject) => {
      const id = this.next_id++;
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        reject(new RequestError({ message: `'${what}' was not answered in time`, code: "timeout" }));
      }, kPatienceOf[what] ?? kPatience);
      this.waiting.set(id, { resolve: resolve as (answer: unknown) => void, reject, timer });
      socket.send(JSON.stringify({ ...fields, id, do: what }));
    });
  }
  on<Name extends keyof Topics>(name: Name, listener: (message: Topics[Name]) => void): Unsubscribe {
    let listeners = this.topics.get(name);
    if (!listeners) this.topics.set(name, (listeners = new Listeners()));
    return listeners.add(listener as (message: unknown) => void);
  }
  on_frame(listener: (frame: Frame) => void): Unsubscribe {
    return this.frames.add(listener);
  }
  on_picture(listener: (picture: Picture) => void): Unsubscribe {
    return this.pictures.add(listener);
  }
  on_open(listener: (open: boolean) => void): Unsubscribe {
    if (this.is_open) queueMicrotask(() => listener(true));
    return this.opens.add(listener);
  }
  asset(path: string): string {
    return this.assets && this.assets + path;
  }

  private open(): void {
    clearTimeout(this.retry);
    this.retry = undefined;
    const socket = this.connect();
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.is_open = true;
      this.delay = kFirstDelay;
      this.opens.publish(true);
      for (const [what, fields] of this.standing) this.request(what, fields).catch(() => {});
    };
    socket.onmessage = ({ data }) => {
      try {
        if (typeof data === "string") this.take_text(data);
        else this.take_bytes(data as ArrayBuffer, socket);
      } catch (error) {
        console.error("a message that cannot be read:", error);
      }
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = null;
      this.newest = null;
      this.is_open = false;
      for (const { reject, timer } of this.waiting.values()) {
        clearTimeout(timer);
        reject(new RequestError({ message: "the connection to the studio was lost", code: "closed" }));
      }
      this.waiting.clear();
      this.opens.publish(false);
      this.retry = setTimeout(() => this.open(), this.delay);
      this.delay = Math.min(2 * this.delay, kLongestDelay);
    };
  }

  /** Does not wait for the next try when there is reason to hope. */
  private try_now(): void {
    if (this.retry !== undefined) this.open();
  }

  private take_text(text: string): void {
    const message = JSON.parse(text) as { id?: number; ok?: boolean; error?: Failure; topic?: string; assets?: string };
    if (typeof message.topic === "string") {
      this.topics.get(message.topic)?.publish(message);
      return;
    }
    const waiting = this.waiting.get(message.id ?? -1);
    if (!waiting) return;
    this.waiting.delete(message.id!);
    clearTimeout(waiting.timer);
    if (typeof message.assets === "string") this.assets = message.assets;
    if (message.ok) waiting.resolve(message);
    else waiting.reject(new RequestError(message.error ?? { message: "refused without a reason" }));
  }

  private take_bytes(data: ArrayBuffer, socket: Socket): void {
    const say = (text: string) => {
      if (socket.readyState === kOpen) socket.send(text);
    };
    if (new Uint8Array(data, 0, 1)[0] === 2) {
      try {
        this.pictures.publish(decode_picture(data));
      } finally {
        say("p");
      }
      return;
    }
    let frame: Frame;
    try {
      frame = decode_frame(data);
    } catch (error) {
      say("a");
      throw error;
    }
    const due = this.newest !== null;
    this.newest = frame;
    if (due) return;
    // The answer comes after drawing: a page that is slow gets fewer frames, not a queue of them.
    this.next_picture(() => {
      if (this.socket !== socket) return;
      const now = this.newest;
      this.newest = null;
      if (!now) return;
      this.frames.publish(now);
      say("a");
    });
  }
}

function connect_here(key: string): Socket {
  const address = new URL("socket", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.search = "";
  address.hash = "";
  // A WebSocket has no headers of the page's but this one.
  return new WebSocket(address, ["cogrsim-studio", key]) as unknown as Socket;
}
