"""Questions of the studio's page that are held back, so that a test can look at the page before they are answered."""

import json

_HOLDING = """(() => {
  const send = WebSocket.prototype.send;
  window.heldKinds = KINDS;
  window.held = [];
  WebSocket.prototype.send = function (text) {
    if (window.heldKinds.includes(JSON.parse(text).do)) window.held.push([this, text]);
    else send.call(this, text);
  };
  window.letGo = () => {
    window.heldKinds = [];
    for (const [socket, text] of window.held.splice(0)) send.call(socket, text);
  };
})()"""


def hold(page, *kinds):
    """From the next loading of the page on, holds back what it asks of these kinds."""
    page.add_init_script(_HOLDING.replace("KINDS", json.dumps(kinds)))


def let_go(page):
    """Asks what was held back, and holds back nothing more."""
    page.evaluate("window.letGo()")
