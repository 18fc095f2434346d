// The canvas: renderer, lights, and a resolution that follows the speed of the machine that draws.
import { AmbientLight, Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, WebGLRenderer, SRGBColorSpace } from "../vendor/three/three.module.min.js";
import { token } from "./palette.js";

/** Frames per second that the resolution is adapted to. */
const REQUESTED_FPS = 24;
/** Fraction of the full resolution below which the picture is too coarse. */
const COARSEST = 0.45;
/** Rest after which a finer frame is drawn, ms, and its resolution, whose edges are smooth once it is scaled down. */
const REST = 800;
const FINEST = 1.6;
/** Time between two changes of the resolution, ms. */
const PATIENCE = 400;

/** Names of renderers that draw without a graphics processor. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/**
 * Whether a WebGL context is drawn by the processor.
 * @param {WebGLRenderingContext|WebGL2RenderingContext} gl
 */
function drawnBySoftware(gl) {
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  return SOFTWARE.test(String(gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER)));
}

/** Draws a scene whenever something changed. */
export class Stage {
  /** @param {HTMLCanvasElement} canvas @param {boolean} [printed] whether the canvas keeps its picture, so that it can be printed */
  constructor(canvas, printed = false) {
    this.canvas = canvas;
    const probe = document.createElement("canvas").getContext("webgl2");
    if (!probe) throw new Error("This browser draws no WebGL 2.");
    this.software = drawnBySoftware(probe);
    probe.getExtension("WEBGL_lose_context")?.loseContext();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, alpha: !this.software, powerPreference: "high-performance", preserveDrawingBuffer: printed });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.005, 100);
    this.key = new DirectionalLight(0xffffff, 2.1);
    this.sky = new HemisphereLight(0xffffff, 0x8090a0, 1.5);
    this.fill = new AmbientLight(0xffffff, 0.25);
    this.scene.add(this.key, this.key.target, this.sky, this.fill);
    /** Fraction of the resolution of the screen. */
    this.fraction = this.software ? 0.6 : 1;
    this.fps = 0;
    this.frames = 0;
    /** Whether there is something to draw. */
    this.ready = false;
    this.changed = true;
    this.refined = false;
    this.touched = 0;
    this.last = 0;
    this.lastChange = 0;
    /** @type {((now: number) => void)[]} Called before a frame is drawn. */
    this.before = [];
    /** @type {(() => void)[]} Called once the first frame stands. */
    this.first = [];
    this.misfits = false;
    this.resize();
    this.observer = new ResizeObserver(() => this.refit());
    this.observer.observe(canvas);
    this.recolour();
    this.running = true;
    const loop = (/** @type {number} */ now) => {
      if (!this.running) return;
      requestAnimationFrame(loop);
      this.tick(now);
    };
    requestAnimationFrame(loop);
    // A frame that is due is drawn before it is printed.
    if (printed) addEventListener("beforeprint", () => { if (this.running) this.tick(performance.now()); });
  }

  /** Asks for a frame. */
  invalidate() {
    this.changed = true;
    this.touched = performance.now();
  }

  /** Ends the loop. */
  stop() {
    this.running = false;
    this.observer.disconnect();
    this.renderer.dispose();
  }

  /** Colours of the theme. */
  recolour() {
    const paper = token("--paper"), dark = paper[0] < 0.5;
    // An opaque canvas: what it lies on need not be drawn with it.
    this.renderer.setClearColor(new Color().setRGB(paper[0], paper[1], paper[2], SRGBColorSpace), this.software ? 1 : 0);
    this.sky.intensity = dark ? 1.15 : 1.75;
    this.sky.groundColor = new Color(dark ? 0x20262e : 0x8b95a1);
    this.key.intensity = dark ? 1.7 : 2.0;
    this.invalidate();
  }

  /** Fits the resolution with the next frame: from then until it is drawn a canvas is empty. */
  refit() {
    this.misfits = this.changed = true;
  }

  resize(fraction = this.fraction) {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, this.software ? 1 : 2) * fraction);
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
  }

  /** @param {number} now */
  tick(now) {
    if (!this.canvas.clientWidth || !this.ready) return;
    // Once everything rests, one finer frame is drawn.
    const refine = !this.changed && this.software && !this.refined && performance.now() - this.touched > REST;
    if (!this.changed && !refine) return;
    if (this.misfits || refine !== this.refined) this.resize(refine ? FINEST : this.fraction);
    this.refined = refine;
    this.changed = this.misfits = false;
    for (const call of this.before) call(now);
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
    if (this.frames === 1) this.first.forEach((call) => call());
    if (!refine) this.pace(now);
  }

  /**
   * Adapts the resolution to the time between frames.
   * @param {number} now
   */
  pace(now) {
    const elapsed = now - this.last;
    this.last = now;
    // A pause is not a slow frame.
    if (!(elapsed > 0 && elapsed < 1000)) return;
    this.fps = this.fps ? 0.93 * this.fps + 0.07 * (1000 / elapsed) : 1000 / elapsed;
    if (!this.software || now - this.lastChange < PATIENCE || this.frames < 8) return;
    const requested = this.fps < REQUESTED_FPS ? this.fraction * (this.fps < 0.5 * REQUESTED_FPS ? 0.75 : 0.88) : this.fps > 1.3 * REQUESTED_FPS ? this.fraction * 1.06 : this.fraction;
    const fraction = Math.min(1, Math.max(COARSEST, requested));
    if (Math.abs(fraction - this.fraction) < 0.01) return;
    this.fraction = fraction;
    this.lastChange = now;
    this.refit();
  }
}
