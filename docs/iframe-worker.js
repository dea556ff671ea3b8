// Material searches in a Worker. Browsers refuse workers to pages that are opened from a disk.
// There, a hidden frame runs the script of the worker. Its functions of a worker are these.
// Material's plugin "offline" needs "iframe-worker" in the name of this file.
"use strict";

function run(frame, address) {
  return new Promise((done, failed) => {
    const script = frame.contentDocument.createElement("script");
    script.onload = done;
    script.onerror = () => failed(new Error(`${address} could not be loaded`));
    script.src = address;
    frame.contentDocument.body.append(script);
  });
}

class FrameWorker extends EventTarget {
  #frame = document.createElement("iframe");
  #running;

  constructor(address) {
    super();
    this.#frame.hidden = true;
    const opened = new Promise((done) => this.#frame.addEventListener("load", done, { once: true }));
    document.body.append(this.#frame);
    this.#running = opened.then(() => this.#start(new URL(address, document.baseURI)));
  }

  async #start(address) {
    const inside = this.#frame.contentWindow;
    inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
    inside.importScripts = async (...more) => {
      for (const one of more) await run(this.#frame, one);
    };
    await run(this.#frame, address);
  }

  async postMessage(data) {
    await this.#running;
    this.#frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
  }

  terminate() {
    this.#frame.remove();
  }
}

if (location.protocol === "file:") window.Worker = FrameWorker;
