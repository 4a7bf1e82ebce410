"""A client of yaml-language-server, which editors talk to: diagnostics, hover and completion of a file."""

from __future__ import annotations

import json
import subprocess
import time
from pathlib import Path
from types import TracebackType
from typing import Any

PATIENCE_S = 60.0


class LanguageServer:
    """The server with one folder; speaks the Language Server Protocol over stdio."""

    def __init__(self, command: list[str], folder: Path) -> None:
        self.process = subprocess.Popen(
            [*command, "--stdio"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self.number = 0
        self.notes: list[dict[str, Any]] = []
        self.ask("initialize", {"processId": None, "rootUri": folder.as_uri(), "capabilities": CAPABILITIES})
        self.tell("initialized", {})
        settings = {"yaml": SETTINGS}
        self.tell("workspace/didChangeConfiguration", {"settings": settings})

    def __enter__(self) -> LanguageServer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.process.kill()
        self.process.wait()

    def diagnostics(self, path: Path, text: str) -> list[str]:
        """Messages about a text as if it stood in a file, each with its line (from 1)."""
        uri = path.as_uri()
        document = {"uri": uri, "languageId": "yaml", "version": 1, "text": text}
        self.notes.clear()
        self.tell("textDocument/didOpen", {"textDocument": document})
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            for note in self.notes:
                if note.get("method") == "textDocument/publishDiagnostics" and note["params"]["uri"] == uri:
                    found = note["params"]["diagnostics"]
                    return [f"{d['range']['start']['line'] + 1}: {d['message']}" for d in found]
            self._read()
        raise TimeoutError(path)

    def hover(self, path: Path, line: int, column: int) -> str:
        """What is shown over a place, counted from 1."""
        found = self.ask("textDocument/hover", _at(path, line, column))
        return "" if not found else json.dumps(found["contents"], ensure_ascii=False)

    def completion(self, path: Path, line: int, column: int) -> list[str]:
        """What is offered at a place, counted from 1."""
        found = self.ask("textDocument/completion", _at(path, line, column))
        items = found["items"] if isinstance(found, dict) else found or []
        return [item["label"] for item in items]

    def ask(self, method: str, params: dict[str, Any]) -> Any:
        """The result of a request."""
        self.number += 1
        number = self.number
        self._write({"jsonrpc": "2.0", "id": number, "method": method, "params": params})
        while True:
            message = self._read()
            if message.get("id") == number and "method" not in message:
                if "error" in message:
                    raise RuntimeError(message["error"])
                return message.get("result")

    def tell(self, method: str, params: dict[str, Any]) -> None:
        """A notification."""
        self._write({"jsonrpc": "2.0", "method": method, "params": params})

    def _write(self, message: dict[str, Any]) -> None:
        assert self.process.stdin is not None
        body = json.dumps(message).encode()
        self.process.stdin.write(f"Content-Length: {len(body)}\r\n\r\n".encode() + body)
        self.process.stdin.flush()

    def _read(self) -> dict[str, Any]:
        """The next message; requests of the server get an answer."""
        assert self.process.stdout is not None
        length = 0
        while line := self.process.stdout.readline().strip():
            if line.lower().startswith(b"content-length:"):
                length = int(line.partition(b":")[2])
        if not length:
            raise RuntimeError("the server has ended")
        message: dict[str, Any] = json.loads(self.process.stdout.read(length))
        if "id" in message and "method" in message:
            wanted = message["method"] == "workspace/configuration"
            items = message["params"]["items"] if wanted else []
            answer = [SETTINGS if item.get("section") == "yaml" else {} for item in items]
            self._write({"jsonrpc": "2.0", "id": message["id"], "result": answer if wanted else None})
        elif "method" in message:
            self.notes.append(message)
        return message


SETTINGS = {
    "validate": True,
    "hover": True,
    "completion": True,
    "yamlVersion": "1.2",
    "schemaStore": {"enable": False},
}
CAPABILITIES: dict[str, Any] = {
    "textDocument": {
        "hover": {"contentFormat": ["markdown"]},
        "completion": {"completionItem": {"snippetSupport": True}},
        "publishDiagnostics": {},
    },
    "workspace": {"configuration": True},
}


def _at(path: Path, line: int, column: int) -> dict[str, Any]:
    return {
        "textDocument": {"uri": path.as_uri()},
        "position": {"line": line - 1, "character": column - 1},
    }
