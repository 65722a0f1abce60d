// Drawing thousands of robots pixel by pixel. In a browser without a graphics card, 10,000 robots take a few
// milliseconds; drawing a picture per robot took 50.

import { THERE } from "./frames.js";

/**
 * The pixels that a picture adds around its position.
 * @typedef {object} Stamp
 * @property {number} half
 * @property {Int32Array} offsets
 * @property {Uint32Array} colours
 * @property {Int32Array} stays Share of the ground that stays, in 256ths.
 */

/**
 * Return the 2D context of a canvas.
 * @param {HTMLCanvasElement} canvas
 * @param {CanvasRenderingContext2DSettings} [settings]
 */
export function contextOf(canvas, settings) {
  const context = canvas.getContext("2d", settings);
  if (!context) throw new Error("this browser gives no canvas to draw on");
  return context;
}

export class Crowd {
  constructor() {
    /** @type {Map<number, Stamp>} */
    this.stamps = new Map();
    this.width = this.height = 0;
    this.ground = this.pixels = new Uint32Array(0);
    /** @type {ImageData | null} */
    this.image = null;
  }

  /**
   * Start again on a ground.
   * @param {HTMLCanvasElement} ground
   */
  reset(ground) {
    const { width, height } = ground;
    this.width = width;
    this.height = height;
    this.ground = new Uint32Array(contextOf(ground).getImageData(0, 0, width, height).data.buffer);
    this.image = new ImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.stamps.clear();
  }

  /**
   * Return the pixels of a picture that aren't empty: offset, colour, share of the ground that stays.
   * @param {number} looks
   * @param {HTMLCanvasElement} sprite
   */
  stamp(looks, sprite) {
    const size = sprite.width,
      data = contextOf(sprite).getImageData(0, 0, size, size).data;
    const offsets = [],
      colours = [],
      stays = [];
    for (let k = 0; k < size * size; k++) {
      const [r, g, b, alpha] = data.subarray(4 * k, 4 * k + 4);
      if (alpha < 8) continue;
      const part = alpha / 255;
      offsets.push((Math.floor(k / size) - size / 2) * this.width + (k % size) - size / 2);
      colours.push(((Math.floor(b * part) << 16) | (Math.floor(g * part) << 8) | Math.floor(r * part)) >>> 0);
      stays.push(alpha > 250 ? 0 : Math.round(256 * (1 - part)));
    }
    const stamp = {
      half: size / 2,
      offsets: Int32Array.from(offsets),
      colours: Uint32Array.from(colours),
      stays: Int32Array.from(stays),
    };
    this.stamps.set(looks, stamp);
    return stamp;
  }

  /**
   * Draw robots at their positions; picture(looks) returns the picture for a look.
   * @param {CanvasRenderingContext2D} context
   * @param {Float32Array} px
   * @param {Float32Array} py
   * @param {Uint16Array} flags
   * @param {number} mask
   * @param {(looks: number) => HTMLCanvasElement} picture
   */
  draw(context, px, py, flags, mask, picture) {
    const { pixels, width, height } = this;
    pixels.set(this.ground);
    for (let i = 0; i < flags.length; i++) {
      if (!(flags[i] & THERE)) continue;
      const looks = flags[i] & mask,
        stamp = this.stamps.get(looks) ?? this.stamp(looks, picture(looks));
      const { half, offsets, colours, stays } = stamp,
        x = Math.max(half, Math.min(Math.round(px[i]), width - half)), // it stays within the edge
        y = Math.max(half, Math.min(Math.round(py[i]), height - half)),
        place = y * width + x;
      for (let k = 0; k < offsets.length; k++) {
        const at = place + offsets[k],
          stay = stays[k];
        if (!stay) {
          pixels[at] = 0xff000000 | colours[k];
          continue;
        }
        const under = pixels[at];
        const redBlue = (Math.imul(under & 0xff00ff, stay) >>> 8) & 0xff00ff,
          green = (((under & 0xff00) * stay) >>> 8) & 0xff00;
        pixels[at] = 0xff000000 | (colours[k] + redBlue + green);
      }
    }
    if (this.image) context.putImageData(this.image, 0, 0);
  }
}
