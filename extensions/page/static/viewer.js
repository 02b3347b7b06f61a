// The 3-D viewer in its tab: which time it shows, and requests to show another.
"use strict";

// As Rerun encodes them: the request for the newest data, and in the viewer's state the name and the
// kind of the time line, before its time.
const FOLLOW = [50, 2, 40, 3], TIME_LINE = [10, 3, 10, 1, 116, 16, 2, 26];
let shownAt = null;  // the time that it shows [s]
let sought = null;  // a request, until the viewer is there

// The other name of this host: see `ANCESTORS`.
const OTHER = `http://${location.hostname === "localhost" ? "127.0.0.1" : "localhost"}:${location.port}`;

// The viewer is there as long as its tab is open.
function showViewer(path) {
  const properties = { src: OTHER + path, title: "3-D viewer" };
  shownAt = sought = null;
  element("frame").replaceChildren(...(path ? [made("iframe", properties)] : []));
}

function tellViewer(request) {
  document.querySelector("iframe").contentWindow.postMessage(new Uint8Array(request), "*");
}

// Let it stand still at a time [s].
function seek(time) {
  const varint = (number) => (number < 128 ? [number] : [number % 128 + 128, ...varint(Math.floor(number / 128))]);
  const value = [8, ...varint(Math.round(time * 1e9))];
  const cursor = [18, ...TIME_LINE.slice(1, 5), 26, value.length, ...value, 40, 1];
  sought = [50, cursor.length, ...cursor];
}

window.addEventListener("message", ({ data, source }) => {
  const frame = document.querySelector("iframe");
  if (!frame || source !== frame.contentWindow || !(data instanceof Uint8Array)) return;
  let at = data.findLastIndex((_, i) => TIME_LINE.every((byte, j) => data[i + j] === byte));
  if (at < 0) return;
  if (sought) tellViewer(sought);
  sought = null;
  at += TIME_LINE.length + 2;
  let nanoseconds = 0, scale = 1;
  do {
    nanoseconds += (data[at] & 127) * scale;
    scale *= 128;
  } while (data[at++] > 127);
  shownAt = nanoseconds / 1e9;
});
