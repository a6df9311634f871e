"""A local HTTP server that fails on demand, for the download tests."""

from __future__ import annotations

import http.server
import threading


class DataServer:
    """Serves `files` by name; `faults[name]` lists what happens to its next requests.

    A fault is an HTTP status, `"cut"` (the transfer breaks off halfway), `"page"` (a web page with status 200) or
    `"stall"` (half of it, then nothing until `released`).
    """

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.faults: dict[str, list[int | str]] = {}
        self.requests: list[str] = []
        self.released = threading.Event()
        server = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                name = self.path.rpartition("/")[2]
                server.requests.append(name)
                faults = server.faults.get(name, [])
                fault = faults.pop(0) if faults else None
                if isinstance(fault, int) or name not in server.files:
                    self.send_error(fault if isinstance(fault, int) else 404)
                    return
                body = b"<html>Sign in</html>" if fault == "page" else server.files[name]
                self.send_response(200)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body[: len(body) // 2] if fault in ("cut", "stall") else body)
                self.wfile.flush()
                if fault == "stall":
                    server.released.wait(30)

            def log_message(self, format: str, *args: object) -> None:
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.02})
        self._thread.start()

    def close(self) -> None:
        """From now on connections are refused."""
        self.released.set()
        if not self._thread.is_alive():
            return
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
