// Made from the table of the protocol, server/protocol_table.cpp: see the test "the page's types are those
// of the table". In words: PROTOCOL.md.
import type {
  BodyDistance,
  CameraWish,
  CompletionItem,
  Debug,
  DebugBreakpointWish,
  DebugVariable,
  DocumentState,
  Events,
  FigureAxis,
  FigureSeries,
  FirstDivergence,
  Goodbye,
  KeptController,
  LeftOut,
  Messages,
  Op,
  PathPart,
  PlotInfo,
  Pose,
  Problem,
  Problems,
  ReloadedController,
  RunEvent,
  Scene,
  SceneTest,
  SeriesPart,
  SignalInfo,
  SourceFile,
  StartFile,
  Status,
  TestVerdict,
  Tree,
  Unsaved,
  Vec3,
} from "./protocol_types";

export type * from "./protocol_types";

/** The protocol that this page speaks; `hello` answers the server's. */
export const kProtocol = 4;

/** The messages that the server publishes unasked, by topic. */
export interface Topics {
  status: Status;
  scene: Scene;
  document: DocumentState;
  unsaved: Unsaved;
  tree: Tree;
  problems: Problems;
  messages: Messages;
  events: Events;
  debug: Debug;
  goodbye: Goodbye;
}

/** What a page asks, with its fields and the answer's. */
export interface Requests {
  /** comes first; may have fields that the server does not know. A page of another protocol loads itself again, once. Afterwards every topic is sent once */
  hello: {
    fields: Record<string, never>;
    answer: {
      /** number of the server's protocol */
      protocol: number;
      role: "operator" | "viewer";
      client: number;
      version: string;
      kind: "scene" | "recording" | "bundle" | "start";
      file: string;
      allow_build: boolean;
      /** where textures are: `/asset/SECRET/` */
      assets?: string;
      backends: string[];
    };
  };
  /** what can be opened; only while nothing is, with `kind` "start" */
  start: {
    fields: {
      /** below the studio's folder, whose files are listed */
      folder?: string;
    };
    answer: {
      /** the studio's own, absolute */
      folder: string;
      /** absolute */
      recent: string[];
      files: StartFile[];
      examples: string[];
      robots: string[];
    };
  };
  /** examples are copied into the studio's folder, robots get a scene there, models of other formats are imported into one. Then the file is served: pages load themselves again */
  "start-open": {
    fields: {
      what: "open" | "new" | "example" | "robot" | "import";
      /** as `start` lists it; of a new scene or a dropped model: a file name */
      name: string;
      /** new, import: what the file holds */
      text?: string;
    };
    answer: {
      file: string;
    };
  };
  /** runs at the present speed; pauses at the scene's duration */
  play: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** while a plugin call is waited for, it is answered at once, and the run's state is "paused"; it takes effect when the call returns */
  pause: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** back to time 0 from the present text, paused; the old frames are gone. A controller that is waited for is ended, if it has a process of its own; so does `restart` */
  stop: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** `stop`, then `play` */
  restart: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** so many steps, then paused */
  step: {
    fields: {
      count?: number;
    };
    answer: Record<string, never>;
  };
  /** simulated seconds per wall-clock second */
  speed: {
    fields: {
      /** null: as fast as possible */
      factor?: number | null;
    };
    answer: Record<string, never>;
  };
  /** takes effect at once; another result, not another speed */
  dt: {
    fields: {
      /** [s]; null: the scene's own */
      value?: number | null;
    };
    answer: Record<string, never>;
  };
  /** the run continues there, from the same state; so does a scene that the engine before refused */
  backend: {
    fields: {
      name: string;
      /** what the scene is without from now on, on this engine and others, as after `cogrsim run --without`; null: as before */
      without?: string[] | null;
    };
    answer: {
      /** what could not be carried over */
      notes: string[];
    };
  };
  /** what an engine lacks of the scene, the newest one that compiled */
  lacking: {
    fields: {
      /** of a backend; "": the scene's */
      name: string;
      /** as the second run of `compare`: of the scene that runs now */
      beside?: boolean | null;
    };
    answer: {
      /** the other engine of a comparison, where it is that one that lacks something */
      name: string;
      /** what it lacks of the scene and can be left out */
      left_out: LeftOut[];
      /** what it lacks and cannot: messages */
      needed: string[];
    };
  };
  /** only while paused, and not while comparing: replaces the controllers' running libraries by those on disk now */
  reload: {
    fields: {
      /** null: all of them */
      controller?: string | null;
    };
    answer: {
      reloaded: ReloadedController[];
      /** with a name that is an error */
      kept: KeptController[];
    };
  };
  /** ends the process of the controller that the run waits for (`waiting` in `status`), which is a fault of it. Refused when there is none, or when it runs in the studio's process */
  "end-controller": {
    fields: Record<string, never>;
    answer: {
      controller: string;
    };
  };
  /** begins or ends a recording */
  record: {
    fields: {
      on?: boolean;
      /** a bare name, beside the scene */
      file?: string;
    };
    answer: {
      file?: string;
      /** [s] */
      from?: number;
    };
  };
  /** this client now views the last frame at or before it */
  seek: {
    fields: {
      /** [s] */
      time: number;
    };
    answer: {
      /** [s] */
      time: number;
    };
  };
  /** this client views the frame before the one it sees */
  "step-back": {
    fields: Record<string, never>;
    answer: {
      /** [s] */
      time: number;
    };
  };
  /** this client follows the newest frame again */
  live: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** what comes in the tail of frames for this client */
  subscribe: {
    fields: {
      contacts?: boolean;
      readings?: boolean;
      joints?: boolean;
    };
    answer: Record<string, never>;
  };
  /** a second run beside the first, in lockstep, both from time 0 */
  compare: {
    fields: {
      /** null: the same */
      backend?: string | null;
      /** [s]; null: the same */
      step?: number | null;
      /** of both, as in `backend` */
      without?: string[] | null;
    };
    answer: Record<string, never>;
  };
  /** the first run continues without the second */
  "compare-off": {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** what can be drawn */
  signals: {
    fields: Record<string, never>;
    answer: {
      signals: SignalInfo[];
    };
  };
  /** of the frames that are kept; intervals with more than one frame keep the lowest and highest (equal otherwise) */
  series: {
    fields: {
      signals: string[];
      /** [s]; null: from the start */
      from?: number | null;
      /** [s]; null: to the end */
      to?: number | null;
      points?: number;
      /** the second run's */
      run?: "ghost";
    };
    answer: {
      time: number[];
      series: SeriesPart[];
    };
  };
  /** of a comparison */
  divergence: {
    fields: Record<string, never>;
    answer: {
      time: number[];
      /** largest distance of two bodies of one name [m] */
      worst: (number | null)[];
      /** [rad] */
      worst_angle: (number | null)[];
      /** the ten worst */
      bodies: BodyDistance[];
      first: FirstDivergence | null;
      labels: [string, string];
    };
  };
  /** the scene's own figures */
  plots: {
    fields: Record<string, never>;
    answer: {
      plots: PlotInfo[];
    };
  };
  /** the data of one */
  figure: {
    fields: {
      /** its name */
      plot: string;
    };
    answer: {
      name?: string;
      kind: string;
      title?: string;
      x?: FigureAxis;
      y?: FigureAxis;
      z?: FigureAxis;
      series: FigureSeries[];
    };
  };
  /** what is new of the paths of the run, made from every step; of another revision nothing is known */
  paths: {
    fields: {
      revision?: number;
      /** points known of each path */
      counts?: number[];
    };
    answer: {
      /** with another one all earlier points are void */
      revision: number;
      /** up to there all is known [s]; null: nothing is */
      until: number | null;
      paths: PathPart[];
    };
  };
  /** of the whole run */
  events: {
    fields: {
      /** index */
      from?: number;
    };
    answer: {
      events: RunEvent[];
    };
  };
  /** from now on pictures of these (of sensors or saved views) come whenever what this client sees has changed, one at a time; an empty list stops all rendering for it */
  cameras: {
    fields: {
      show: CameraWish[];
    };
    answer: Record<string, never>;
  };
  /** one picture of the whole scene, for pages without WebGL; comes as a binary message with `name` "" */
  view: {
    fields: {
      /** [pixel] */
      width?: number;
      /** [pixel] */
      height?: number;
      /** null: one that shows the whole scene */
      pose?: Pose | null;
      /** [rad] */
      fov?: number;
    };
    answer: Record<string, never>;
  };
  /** changes with the same non-empty `group` in a row make one step of the history */
  "set-text": {
    fields: {
      version: number;
      text: string;
      group?: string;
    };
    answer: {
      version: number;
    };
  };
  /** all or nothing, one step of the history */
  edit: {
    fields: {
      version: number;
      ops: Op[];
      label?: string;
    };
    answer: {
      version: number;
      /** ids */
      created: number[];
    };
  };
  /** one step back in the history */
  undo: {
    fields: Record<string, never>;
    answer: {
      version: number;
      label: string;
    };
  };
  /** one step forward */
  redo: {
    fields: Record<string, never>;
    answer: {
      version: number;
      label: string;
    };
  };
  /** continues with the copy, if there is one */
  save: {
    fields: {
      /** a bare name: a copy under it */
      file?: string;
    };
    answer: {
      file: string;
      backup: string;
    };
  };
  /** the text as it was last saved */
  revert: {
    fields: Record<string, never>;
    answer: {
      version: number;
      text: string;
    };
  };
  /** what an offer (see the topic `unsaved`) holds */
  unsaved: {
    fields: {
      number: number;
    };
    answer: {
      text: string;
    };
  };
  /** the text is that of the offer now, one step of the history; the file stays as it is. Refused as "stale" when the offer is gone */
  restore: {
    fields: {
      number: number;
    };
    answer: {
      version: number;
    };
  };
  /** the offer is deleted */
  discard: {
    fields: {
      number: number;
    };
    answer: Record<string, never>;
  };
  /** the vocabulary: see *Schema* */
  schema: {
    fields: Record<string, never>;
    answer: {
      schema: object;
    };
  };
  /** what may stand there */
  complete: {
    fields: {
      text: string;
      /** code points */
      offset: number;
    };
    answer: {
      from: number;
      items: CompletionItem[];
    };
  };
  /** of the bodies in them as one */
  mass: {
    fields: {
      /** ids */
      elements: number[];
    };
    answer: {
      /** [kg] */
      mass: number;
      com: Vec3;
      /** xx yy zz xy xz yz, about the centre of mass */
      inertia: number[];
      bodies: string[];
    };
  };
  /** controllers' sources beside the scene */
  sources: {
    fields: Record<string, never>;
    answer: {
      files: SourceFile[];
    };
  };
  /** one of them */
  "open-source": {
    fields: {
      name: string;
    };
    answer: {
      text: string;
      /** of its content */
      version: string;
    };
  };
  /** refused as "stale" when another program changed the file */
  "save-source": {
    fields: {
      name: string;
      text: string;
      /** as it was opened */
      version?: string;
    };
    answer: {
      version: string;
    };
  };
  /** only with `--allow-build`: builds the project beside the scene, and takes its plugins */
  build: {
    fields: {
      /** with debug information, not optimised */
      debug?: boolean;
    };
    answer: {
      /** false: the compiler complained */
      built: boolean;
      log: string;
      problems: Problem[];
    };
  };
  /** gdb attaches to the controller's process, and to each that replaces it. `debug` says what came of it */
  "debug-attach": {
    fields: {
      /** dotted name */
      controller: string;
    };
    answer: Record<string, never>;
  };
  /** gdb ends, and the controller goes on */
  "debug-detach": {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** these instead of all before; also without a controller in the debugger */
  "debug-breakpoints": {
    fields: {
      breakpoints: DebugBreakpointWish[];
    };
    answer: Record<string, never>;
  };
  /** of the controller. A step that leaves its sources ends where they are entered next. A pause between two updates takes effect with the next */
  "debug-run": {
    fields: {
      how: "continue" | "over" | "into" | "out" | "pause";
    };
    answer: Record<string, never>;
  };
  /** arguments and locals, while it stands */
  "debug-variables": {
    fields: {
      /** index in `frames` */
      frame?: number;
    };
    answer: {
      variables: DebugVariable[];
      /** there are others */
      more: boolean;
    };
  };
  /** members or elements, 200 at most */
  "debug-children": {
    fields: {
      /** `children` of a variable */
      of: string;
    };
    answer: {
      variables: DebugVariable[];
      /** there are others */
      more: boolean;
    };
  };
  /** an expression of C++; calls in it are made */
  "debug-evaluate": {
    fields: {
      expression: string;
      /** index in `frames` */
      frame?: number;
    };
    answer: {
      variable: DebugVariable;
    };
  };
  /** sets a motor's target before the next step, until a controller or something else sets it */
  motor: {
    fields: {
      /** dotted name */
      motor: string;
      /** in its unit */
      target: number;
    };
    answer: {
      /** as it is limited */
      target: number;
    };
  };
  /** sets an input of a controller (`controllers` in `status`) before the next step */
  input: {
    fields: {
      /** dotted name */
      controller: string;
      /** name */
      input: string;
      /** in its unit */
      value: number;
    };
    answer: {
      /** as it is limited */
      value: number;
    };
  };
  /** pulls a body by a spring in every step, until `release`, or until this client leaves */
  grab: {
    fields: {
      /** dotted name */
      body: string;
      /** of it, in its frame [m] */
      point: Vec3;
      /** in the world [m] */
      target: Vec3;
      /** [N/m]; null: by the mass */
      stiffness?: number | null;
    };
    answer: {
      /** [N/m], as it is limited by the step */
      stiffness: number;
      /** [N s/m] */
      damping: number;
    };
  };
  /** where it is pulled to from now on */
  "grab-move": {
    fields: {
      /** in the world [m] */
      target: Vec3;
    };
    answer: Record<string, never>;
  };
  /** ends the pulling of this client */
  release: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** `restart`, with all that was done by hand in this run, or in the one before: the same states come again. Refused after an edit or a change of the engine in the run */
  repeat: {
    fields: Record<string, never>;
    answer: {
      inputs: number;
    };
  };
  /** those of the present text; none while it has errors */
  tests: {
    fields: Record<string, never>;
    answer: {
      /** of the text */
      version: number;
      tests: SceneTest[];
    };
  };
  /** runs a test of the present text from its start, in a process of its own, and answers when it is over */
  test: {
    fields: {
      /** index in `tests` */
      test: number;
      /** several: for `agree` alone */
      backends: string[];
      /** of the text that `tests` were of */
      version: number;
    };
    answer: {
      status: "passed" | "failed" | "error";
      /** why there is no verdict */
      message: string;
      verdicts: TestVerdict[];
      /** of the run, that the test does not check */
      errors: string[];
    };
  };
  /** ends the test that runs */
  "test-cancel": {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
}

export type RequestName = keyof Requests;
export type Answer<Name extends RequestName> = Requests[Name]["answer"];
export type Hello = Answer<"hello">;
export type Paths = Answer<"paths">;
