// Where a page has its data from: a server with a token, or the file that it was opened from.

const inside = document.getElementById("state");

/** Whether the page is a file of its own, in which nothing can be changed. */
export const offline = inside !== null;

const token = new URLSearchParams(location.search).get("token") ?? "";
const headers = { "X-Orusd-Token": token };

/** What went wrong, where, and what to do about it. */
export class Refused extends Error {
  constructor({ message, place, remedy }) {
    super(message);
    this.place = place;
    this.remedy = remedy;
  }
}

/** The state of the page when it opens. */
export async function state() {
  return offline ? JSON.parse(inside.textContent) : asked("/state");
}

/** A larger thing by its name, as an ArrayBuffer. */
export async function resource(name) {
  if (!offline) return (await got(`/resource/${name}`)).arrayBuffer();
  const held = document.querySelector(`script[data-resource="${name}"]`);
  if (held === null) throw new Refused({ message: `the page does not hold ${name}` });
  const packed = await fetch(`data:application/octet-stream;base64,${held.textContent}`);
  const whole = packed.body.pipeThrough(new DecompressionStream("deflate"));
  return new Response(whole).arrayBuffer();
}

/** Do something; gives what came of it. */
export async function send(command, given = {}) {
  if (offline) throw new Refused({ message: "a page in a file can only be looked at" });
  const body = JSON.stringify(given);
  return asked(`/command/${command}`, { method: "POST", body });
}

/** Call back with whatever the server tells later. */
export function listen(handler) {
  if (offline) return;
  const events = new EventSource(`/events?token=${encodeURIComponent(token)}`);
  events.onmessage = (told) => handler(JSON.parse(told.data));
}

async function asked(address, how = {}) {
  return (await got(address, how)).json();
}

async function got(address, how = {}) {
  let answer;
  try {
    answer = await fetch(address, { ...how, headers });
  } catch {
    throw new Refused({ message: "orusd does not answer", remedy: "start it again" });
  }
  if (!answer.ok) throw new Refused((await answer.json()).error);
  return answer;
}
