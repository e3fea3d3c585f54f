// Browsers start no worker for a page that is opened from disk. The search of the site then runs in a hidden frame.
if (location.protocol === "file:") {
  window.Worker = class {
    constructor(source) {
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      document.body.append(this.frame);
      const inner = this.frame.contentWindow;
      inner.postMessage = (data) => setTimeout(() => this.onmessage?.({ data: structuredClone(data) }));
      const script = inner.document.createElement("script");
      script.src = source;
      this.loaded = new Promise((done) => script.addEventListener("load", done));
      inner.document.head.append(script);
    }

    postMessage(data) {
      this.loaded.then(() => this.frame.contentWindow.onmessage({ data: structuredClone(data) }));
    }

    terminate() {
      this.frame.remove();
    }
  };
}
