// What people show in a talk: a film of the arena, and the page without its form.

import { $, announce, make } from "./elements.js";

const RATE = 30; // frames per second
const KINDS = ["video/webm;codecs=vp9", "video/webm", "video/mp4"];

/** @type {MediaRecorder | null} */
let recorder = null;

/**
 * Begin a film of a canvas, or end it and save it.
 * @param {HTMLCanvasElement} canvas
 * @param {string} name Of the file, without its ending.
 */
export function film(canvas, name) {
  if (recorder) return recorder.stop();
  const type = KINDS.find((each) => globalThis.MediaRecorder?.isTypeSupported(each));
  if (!type || !canvas.captureStream)
    return announce("This browser can't record: use feasibee run --out film.mp4.");
  recorder = new MediaRecorder(canvas.captureStream(RATE), { mimeType: type });
  recorder.addEventListener("dataavailable", ({ data }) => {
    const download = `${name}.${type.startsWith("video/webm") ? "webm" : "mp4"}`,
      link = make("a", { href: URL.createObjectURL(data), download });
    recorder = null;
    reflect();
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }); // once, when it stops
  recorder.start();
  reflect();
}

function reflect() {
  $("clip").ariaPressed = String(recorder !== null);
  $("clip").textContent = recorder ? "Save the clip" : "Record a clip";
}

// Show the arena and the answer alone, on the whole screen; or leave that.
export async function fillScreen() {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await document.documentElement.requestFullscreen();
  } catch {
    announce("This browser doesn't let the page fill the screen.");
  }
}
