// The start page: what a studio without a file can open.
import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { JSX } from "preact";
import { messageOf, type Link } from "../core/link";
import type { FieldsOf } from "../core/link";
import type { Requests } from "../core/protocol";
import "./start_page.css";

type Choice = Requests["start"]["answer"];
type Wanted = FieldsOf<"start-open">[0];

const kModels = [".urdf", ".xacro", ".sdf", ".world", ".mjcf", ".xml"];

/** "010_two_wheels" as a title: "Two wheels". */
export function titleOf(name: string): string {
  const words = name.replace(/^\d+_/, "").replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function StartPage({ link }: { link: Link }): JSX.Element {
  const [choice, setChoice] = useState<Choice | null>(null);
  const [folder, setFolder] = useState("");
  const [name, setName] = useState("new");
  const [wrong, setWrong] = useState("");
  const [busy, setBusy] = useState(false);
  const [over, setOver] = useState(false);
  useEffect(() => {
    link.request("start", { folder }).then(setChoice, (error: unknown) => setWrong(messageOf(error)));
  }, [folder]);

  const open = (wanted: Wanted): void => {
    setBusy(true);
    setWrong("");
    link.request("start-open", wanted).then(
      () => location.reload(),
      (error: unknown) => {
        setBusy(false);
        setWrong(messageOf(error));
      },
    );
  };
  const take = async (file: File | undefined): Promise<void> => {
    setOver(false);
    if (!file) return;
    const text = await file.text();
    if (file.name.endsWith(".scene.xml")) open({ what: "new", name: file.name, text });
    else if (kModels.some((ending) => file.name.endsWith(ending))) open({ what: "import", name: file.name, text });
    else setWrong(`${file.name} is neither a scene nor a URDF, SDF or MJCF file`);
  };
  const card = (key: string, text: string, wanted: Wanted, title = ""): JSX.Element => (
    <li key={key}>
      <button type="button" disabled={busy} title={title || undefined} onClick={() => open(wanted)}>
        {text}
      </button>
    </li>
  );
  const up = folder.includes("/") ? folder.slice(0, folder.lastIndexOf("/")) : "";
  return (
    <main
      class={over ? "cg-start is-over" : "cg-start"}
      data-testid="start"
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        void take(event.dataTransfer?.files[0]);
      }}
    >
      <h1>CogRSim Studio</h1>
      {wrong !== "" && (
        <p class="cg-start-wrong" role="alert">
          {wrong}
        </p>
      )}
      <section aria-labelledby="cg-start-new">
        <h2 id="cg-start-new">New</h2>
        <form
          onSubmit={(event) => {
            event.preventDefault();
            open({ what: "new", name });
          }}
        >
          <label>
            Name{" "}
            <input value={name} spellcheck={false} onInput={(event) => setName(event.currentTarget.value.trim())} />
          </label>
          <button type="submit" class="cg-primary" disabled={busy || name === ""}>
            New scene
          </button>
        </form>
      </section>
      {choice && choice.recent.length > 0 && (
        <section aria-labelledby="cg-start-recent">
          <h2 id="cg-start-recent">Recent</h2>
          <ul>
            {choice.recent.map((file) => card(file, file.replace(/^.*[/]/, ""), { what: "open", name: file }, file))}
          </ul>
        </section>
      )}
      <section aria-labelledby="cg-start-open">
        <h2 id="cg-start-open">Open or import</h2>
        <p class="cg-muted">
          {choice ? `${choice.folder}${folder === "" ? "" : `/${folder}`}` : ""}. URDF, SDF and MJCF files become
          scenes; they can also be dropped here.
        </p>
        <ul>
          {folder !== "" && (
            <li>
              <button type="button" onClick={() => setFolder(up)}>
                ← back
              </button>
            </li>
          )}
          {choice?.files.map((file) => {
            const label = file.name.replace(/^.*[/]/, "");
            if (file.kind !== "folder")
              return card(file.name, label, { what: file.kind === "model" ? "import" : "open", name: file.name });
            return (
              <li key={file.name}>
                <button type="button" class="cg-start-folder" onClick={() => setFolder(file.name)}>
                  {label}/
                </button>
              </li>
            );
          })}
        </ul>
        <label class="cg-start-choose">
          Choose a file{" "}
          <input
            type="file"
            accept={kModels.join(",")}
            onChange={(event) => void take(event.currentTarget.files?.[0])}
          />
        </label>
      </section>
      {choice && choice.robots.length > 0 && (
        <section aria-labelledby="cg-start-robots">
          <h2 id="cg-start-robots">Robots</h2>
          <ul>{choice.robots.map((robot) => card(robot, titleOf(robot), { what: "robot", name: robot }))}</ul>
        </section>
      )}
      {choice && choice.examples.length > 0 && (
        <section aria-labelledby="cg-start-examples">
          <h2 id="cg-start-examples">Examples</h2>
          <ul>{choice.examples.map((one) => card(one, titleOf(one), { what: "example", name: one }))}</ul>
        </section>
      )}
    </main>
  );
}

/** Instead of the panels, until something was opened: then the page loads itself again. */
export function showStartPage(link: Link): void {
  const root = document.createElement("div");
  document.body.replaceChildren(root);
  document.title = "CogRSim Studio";
  render(<StartPage link={link} />, root);
}
