"""Hold back requests of the studio's page.

This lets a test look at the page before they are answered.
"""

import json

_HOLDING = """(() => {
  const send = WebSocket.prototype.send;
  window.heldKinds = KINDS;
  window.held = [];
  WebSocket.prototype.send = function (text) {
    if (window.heldKinds.includes(JSON.parse(text).do)) window.held.push([this, text]);
    else send.call(this, text);
  };
  const answered = ([socket, text]) => new Promise((done) => {
    const { id } = JSON.parse(text);
    socket.addEventListener("message", ({ data }) => {
      const said = JSON.parse(data);
      if (said.id === id && !("part" in said)) done();
    });
    send.call(socket, text);
  });
  window.letGo = () => {
    window.heldKinds = [];
    const late = new Promise((_, fail) => setTimeout(() => fail(new Error("no answer")), 180_000));
    return Promise.race([late, Promise.all(window.held.splice(0).map(answered))]);
  };
})()"""


def hold(page, *kinds):
    """Hold back the page's requests of these kinds, from its next reload on."""
    page.add_init_script(_HOLDING.replace("KINDS", json.dumps(kinds)))


def let_go(page):
    """Send the requests that were held back, hold back no more, and return when the page has the
    answers.
    """
    page.evaluate("window.letGo()")
