"""Datasets on a web server: streamed, or read by byte ranges."""

import functools
import http.server
import re
import threading

import numpy as np
import pytest
from torch.utils.data import DataLoader

from synthdepth.dataset import PairDataset, PairStream, collate
from synthdepth.errors import DatasetError
from tests.made import make_dataset


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("remote") / "set", shards=4, pairs=2)


@pytest.fixture(scope="module")
def stored(folder):
    """{key: Sample}, read from the disk."""
    return {sample.key: sample for sample in PairDataset(folder)}


def keys_of(samples) -> list[str]:
    return [sample.key for sample in samples]


class Handler(http.server.SimpleHTTPRequestHandler):
    """Files with range requests, as object stores answer them."""

    ranges = True

    def do_GET(self):
        asked = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        if not asked or not self.ranges:
            return super().do_GET()
        first, last = map(int, asked.groups())
        with open(self.translate_path(self.path), "rb") as file:
            file.seek(first)
            data = file.read(last - first + 1)
        self.send_response(206)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Content-Range", f"bytes {first}-{first + len(data) - 1}/*")
        self.end_headers()
        self.wfile.write(data)
        return None

    def log_message(self, *_):
        pass


class PlainHandler(Handler):
    ranges = False


@pytest.fixture
def serve(folder):
    servers = []

    def start(handler):
        handler = functools.partial(handler, directory=str(folder))
        servers.append(http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler))
        threading.Thread(target=servers[-1].serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{servers[-1].server_port}"

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


def test_a_dataset_may_lie_on_a_web_server(serve, stored):
    address = serve(Handler)
    dataset = PairDataset(address, split="test", fields=("rgb", "depth_m"))
    assert all(np.array_equal(s.depth_m, stored[s.key].depth_m) for s in dataset)
    loader = DataLoader(dataset, batch_size=3, num_workers=2, collate_fn=collate)
    assert [key for batch in loader for key in batch.keys] == keys_of(dataset)
    where = {"condition": "fog"}
    fog = {key for key, sample in stored.items() if sample.meta["condition"] == "fog"}
    assert set(keys_of(PairStream(address, where=where))) == fog
    for loader in (PairDataset, PairStream):
        with pytest.raises(DatasetError, match=r"http://127.*/nothing.* cannot be read"):
            loader(f"{address}/nothing")
    with pytest.raises(DatasetError, match="gone.tar cannot be read"):
        list(PairStream(f"{address}/gone.tar"))


def test_a_server_without_ranges_streams_but_does_not_jump(serve, stored):
    address = serve(PlainHandler)
    stream = PairStream(address, shuffle=4)
    assert sorted(keys_of(DataLoader(stream, batch_size=None, num_workers=2))) == sorted(stored)
    with pytest.raises(DatasetError, match="answers no range requests"):
        PairDataset(address)[0]
