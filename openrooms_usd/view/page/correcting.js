// What pages share in which a room is corrected: commands one after the other, taking back,
// composing again, and what other programs change meanwhile.

import { MOVING, folding, helping, undoing } from "orusd/frame.js";
import { button, complain, element, section, tell } from "orusd/panel.js";
import { openRoom } from "orusd/room.js";
import * as source from "orusd/source.js";

// A room is read anew when nothing was done for so long.
const PAUSE_MS = 500;

/** A room that is corrected, and the panel beside it. */
export class Correcting {
  /**
   * renewed(state): called with the state of the room, first and whenever it has changed.
   * help: rows of what else mouse and keys do.
   */
  static async open(root, renewed, help = []) {
    const canvas = element("canvas", { id: "view", tabIndex: 0 });
    const panel = element("aside", { className: "panel" });
    root.append(element("div", { className: "stand" }, canvas), panel);
    folding(panel);
    helping([...MOVING, ...help, ["Ctrl+Z", "undo"], ["Ctrl+Y, Ctrl+Shift+Z", "redo"]]);
    const [state, glb] = await Promise.all([source.state(), source.resource("room.glb")]);
    const room = await openRoom(canvas, glb, state);
    canvas.room = room;
    const made = new Correcting(room, panel, state, renewed);
    const box = room.bounds(state.shell) ?? room.bounds();
    if (box) room.camera.frame(...box);
    return made;
  }

  constructor(room, panel, state, renewed) {
    Object.assign(this, { room, panel, renewed, last: Promise.resolve(), busy: 0 });
    /** While it says true, the picture stays as it is. */
    this.held = () => false;
    this.buttons = {
      undo: button("undo", "undo", () => this.again("undo")),
      redo: button("redo", "redo", () => this.again("redo")),
      compose: button("compose", "compose", () => this.again("compose")),
    };
    const fit = button("fit", "fit view", () => room.fit());
    panel.append(element("div", { id: "told", className: "told" }),
      section("Changes", "changes", element("div", { className: "buttons" }, ...Object.values(this.buttons), fit)));
    undoing(() => this.again("undo"), () => this.again("redo"));
    source.listen(({ event }) => { if (event === "changed") this.look(); });
    this.know(state);
    this.mark(0);
  }

  /** Remember what the file is now, and what can be taken back. */
  know(told) {
    if (told.version === undefined) return;
    this.version = told.version;
    this.buttons.undo.disabled = !told.undo;
    this.buttons.redo.disabled = !told.redo;
    this.buttons.compose.disabled = !told.composes;
    document.body.dataset.version = told.version;
  }

  /**
   * Send a command when all before it are done; gives what came of it, or null where it was refused.
   * shown(reply): brings it to the picture at once, before the room is read anew.
   */
  send(command, given = {}, { shown = () => {}, renew = true, words = "saved" } = {}) {
    this.mark(1);
    const run = async () => {
      try {
        if (command === "compose") tell("composing …");
        const reply = await source.send(command, given);
        this.know(reply);
        shown(reply);
        if (reply.warnings?.length) complain(new Error(reply.warnings.join("\n")));
        else tell(reply.notes?.length && command === "compose" ? reply.notes.join("\n") : words);
        return reply;
      } catch (error) {
        complain(error);
        return null;
      }
    };
    const done = this.last.then(run);
    this.last = done.then(async (reply) => {
      // Also what was refused: the picture may show what was hoped for.
      this.wanted ||= renew || reply === null;
      // Who does one thing after the other does not wait for each to be read anew.
      if (this.wanted && this.busy === 1) await new Promise((ready) => setTimeout(ready, PAUSE_MS));
      if (this.wanted && this.busy === 1) await this.renew();
      this.mark(-1);
    });
    return done;
  }

  again(command) {
    return this.send(command, {}, { words: { undo: "undone", redo: "redone", compose: "composed" }[command] });
  }

  /** The file has changed: check whether this page did it. */
  look() {
    this.last = this.last.then(async () => {
      if ((await source.send("version")).version === this.version) return;
      this.mark(1);
      await this.renew();
      this.mark(-1);
      tell("another program has changed the room");
    }).catch(complain);
  }

  /** Show the room as it is now. */
  async renew() {
    try {
      const [state, glb] = await Promise.all([source.state(), source.resource("room.glb")]);
      this.know(state);
      this.wanted = this.held();
      if (this.wanted) return;
      this.room.surfaces.moves.clear();
      this.room.hidden.clear();
      await this.room.load(glb);
      this.renewed(state);
    } catch (error) {
      complain(error);
    }
  }

  /** Tests and people wait for what is being done. */
  mark(step) {
    this.busy += step;
    document.body.dataset.busy = String(this.busy);
  }
}
