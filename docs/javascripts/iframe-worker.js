// Browsers start no workers for pages opened as files, but the search runs in one. Here an invisible frame stands in.
if (location.protocol === "file:") {
  window.IFrameWorker = class IFrameWorker extends EventTarget {
    constructor(url) {
      super()
      const frame = document.createElement("iframe")
      frame.hidden = true
      document.body.appendChild(frame)
      this.waiting = []
      this.frame = frame
      window.addEventListener("message", event => {
        if (event.source !== frame.contentWindow) return
        const message = new MessageEvent("message", { data: event.data })
        this.dispatchEvent(message)
        if (this.onmessage) this.onmessage(message)
      })
      const page = frame.contentDocument
      page.open()
      page.write("<html><body></body></html>")
      page.close()
      const inside = frame.contentWindow
      inside.postMessage = data => window.dispatchEvent(new MessageEvent("message", { data, source: inside }))
      inside.importScripts = (...urls) => Promise.all(urls.map(address => load(page, address)))
      load(page, new URL(url, location.href).href).then(() => {
        this.ready = true
        this.waiting.forEach(data => this.deliver(data))
      })
    }
    deliver(data) {
      this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }))
    }
    postMessage(data) {
      this.ready ? this.deliver(data) : this.waiting.push(data)
    }
    terminate() {
      this.frame.remove()
    }
  }
  function load(page, url) {
    return new Promise((done, failed) => {
      const script = page.createElement("script")
      script.src = url
      script.onload = done
      script.onerror = failed
      page.body.appendChild(script)
    })
  }
  window.Worker = window.IFrameWorker
}
