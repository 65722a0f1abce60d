// What plot.js uses of uPlot, which the page loads as a script of its own.

interface Chart {
  ctx: CanvasRenderingContext2D;
  bbox: { left: number; top: number; width: number; height: number };
  batch(change: () => void): void;
  destroy(): void;
  redraw(rebuildPaths: boolean, recalculateAxes: boolean): void;
  setData(data: Float64Array[], resetScales: boolean): void;
  setScale(key: string, limits: { min: number; max: number }): void;
  setSize(size: { width: number; height: number }): void;
  valToPos(value: number, scale: string, canvasPixels: boolean): number;
}

declare const uPlot: new (options: object, data: Float64Array[], element: HTMLElement) => Chart;
