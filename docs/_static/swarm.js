// The page that simulates, in a frame of the front page: it gets the site's theme, and its frame the height it asks for.

const frame = /** @type {HTMLIFrameElement} */ (document.querySelector("iframe.swarm"));

function tellTheme() {
  frame.contentWindow?.postMessage({ theme: document.body.dataset.theme || "auto" }, "*");
}

addEventListener("message", ({ source, data }) => {
  if (source !== frame.contentWindow || !(data.height > 0)) return;
  frame.style.height = `${Math.ceil(data.height)}px`;
  tellTheme(); // the page in the frame is there now
});
new MutationObserver(tellTheme).observe(document.body, { attributeFilter: ["data-theme"] });
