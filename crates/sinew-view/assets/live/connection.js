// One WebSocket: states come, commands go. A connection without a message for a second counts as lost and is opened again.
import { GEOMETRY } from "./history.js";
import { KIND, decode, decodeRows, head, json } from "./protocol.js";

/** @import {Session} from "./session.js" */

/** Time between two looks at the connection, ms, and looks without a message after which it is lost. Looks are counted, not
 *  time: a page that had no turn has heard nothing, either. */
const LOOK = 180;
const SILENT_LOOKS = 5;
/** The same for a connection that is still being made. */
const PATIENT_LOOKS = 15;
/** Wait before the next attempt, ms. */
const AGAIN = 700;
/** A command without an answer, ms. */
const UNANSWERED = 4000;
const PROTOCOL = "sinew.live.1";

/** The token of the page's address, which never leaves in a request's line. */
function token() {
  return new URLSearchParams(location.hash.slice(1)).get("token");
}

export class Connection {
  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    /** @type {WebSocket|null} */
    this.socket = null;
    this.silent = 0;
    this.next = 1;
    this.revision = -1;
    this.fetching = false;
    this.tries = 0;
    /** @type {Map<number, (answer: {ok: boolean, error?: string}) => void>} */
    this.waiting = new Map();
  }

  /** Headers of a request off loopback. @returns {Record<string, string>} */
  headers() {
    const secret = token();
    return secret ? { Authorization: `Bearer ${secret}` } : {};
  }

  start() {
    this.open();
    setInterval(() => this.watch(), LOOK);
  }

  async open() {
    this.tries += 1;
    const mine = this.tries;
    const again = () => { if (mine === this.tries) setTimeout(() => mine === this.tries && this.open(), AGAIN); };
    try {
      await this.fetchScene();
    } catch (error) {
      this.session.takeLink(this.session.scene ? "lost" : "connecting");
      if (error instanceof Refused) this.session.tell("notice", { text: error.message, bad: true });
      again();
      return;
    }
    const secret = token(), url = new URL("stream", location.href);
    url.protocol = url.protocol.replace("http", "ws");
    url.hash = "";
    const socket = new WebSocket(url, secret ? [PROTOCOL, `token.${secret}`] : [PROTOCOL]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.silent = 0;
    socket.onmessage = (e) => { if (socket === this.socket) this.take(e.data); };
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.lose();
      again();
    };
  }

  /** Marks the connection as lost; commands that wait are answered so. */
  lose() {
    const { socket } = this;
    this.socket = null;
    socket?.close();
    for (const answer of this.waiting.values()) answer({ ok: false, error: "The connection was lost before the answer." });
    this.waiting.clear();
    this.session.takeLink("lost");
  }

  watch() {
    if (!this.socket) return;
    this.silent += 1;
    if (this.silent < (this.socket.readyState === WebSocket.CONNECTING ? PATIENT_LOOKS : SILENT_LOOKS)) return;
    this.lose();
    this.open();
  }

  async fetchScene() {
    const answer = await fetch("scene", { headers: this.headers(), cache: "no-store" });
    if (answer.status === 401 || answer.status === 403) throw new Refused("The server refused this page: open the address that the program printed, with its token.");
    if (!answer.ok) throw new Error(`scene: ${answer.status}`);
    const scene = await answer.json();
    this.revision = scene.layout_revision ?? -1;
    this.session.takeScene(scene);
  }

  /** The signals before now, of a source whose time can be set. @returns {Promise<import("./protocol.js").State[]>} */
  async fetchHistory() {
    const layout = this.session.scene?.layout.filter(({ name }) => !GEOMETRY.test(name)) ?? [];
    const answer = await fetch("history", { headers: this.headers(), cache: "no-store" });
    const found = answer.status === 200 ? head(await answer.arrayBuffer()) : null;
    return found?.kind === KIND.history && found.revision === this.revision ? decodeRows(found.body, layout) : [];
  }

  /** @param {ArrayBuffer} message */
  take(message) {
    const found = message instanceof ArrayBuffer ? head(message) : null;
    if (!found || !this.session.scene) return;
    this.silent = 0;
    this.session.takeLink("open");
    const { kind, body } = found;
    if (kind === KIND.state) {
      const state = decode(body, this.session.scene.layout);
      if (state) this.session.takeState(state);
      else this.refresh();
    } else if (kind === KIND.scene) this.refresh();
    else if (kind === KIND.event) this.session.tell("event", json(body));
    else if (kind === KIND.answer) {
      const answer = json(body);
      this.waiting.get(answer.id)?.(answer);
      this.waiting.delete(answer.id);
    }
  }

  /** Fetches the scene again, once at a time. */
  async refresh() {
    if (this.fetching) return;
    this.fetching = true;
    try { await this.fetchScene(); } catch { /* The watch sees a server that is gone. */ }
    this.fetching = false;
  }

  /** @param {Record<string, unknown>} message @returns {Promise<{ok: boolean, error?: string}>} */
  send(message) {
    const { socket } = this;
    if (!socket || socket.readyState !== WebSocket.OPEN) return Promise.resolve({ ok: false, error: "Not connected: the command was not sent." });
    const id = this.next++;
    return new Promise((resolve) => {
      const late = setTimeout(() => {
        this.waiting.delete(id);
        resolve({ ok: false, error: "The server did not answer the command." });
      }, UNANSWERED);
      this.waiting.set(id, (answer) => { clearTimeout(late); resolve(answer); });
      socket.send(JSON.stringify({ id, ...message }));
    });
  }
}

/** The server answered that this page may not see it. */
class Refused extends Error {}
