"""Datasets written to folders and to addresses: the same bytes, whatever the network does."""

import itertools
import os
import socket
import socketserver
import threading

import fsspec
import pytest
from fsspec.implementations.memory import MemoryFileSystem

from synthdepth.dataset import PairDataset
from synthdepth.dataset.manifest import MANIFEST, read_manifest
from synthdepth.dataset.shard import partial_of
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.production import remote
from synthdepth.production.remote import RemoteFolder, _own_workspace
from synthdepth.production.storage import GoneError, LocalFolder, storage_of
from tests.shards_made import (
    PAIRS,
    contents,
    in_this_process,
    made_shard,
    render,
    without_rendering,
)


@pytest.fixture(autouse=True)
def _here(monkeypatch, tmp_path_factory):
    """Shards by formula, workspaces in a folder of the test's own, no pauses."""
    without_rendering(monkeypatch)
    monkeypatch.setattr(remote.tempfile, "tempdir", str(tmp_path_factory.mktemp("temp")))
    monkeypatch.setattr(remote.time, "sleep", lambda seconds: None)


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """The contents of a dataset in a folder."""
    folder = tmp_path_factory.mktemp("local") / "set"
    with pytest.MonkeyPatch.context() as patch:
        without_rendering(patch)
        render(folder)
    return contents(folder)


@pytest.fixture
def address():
    """An empty place in memory."""
    yield "memory://bucket/set"
    MemoryFileSystem.store.clear()
    MemoryFileSystem.pseudo_dirs[:] = [""]


def fetched(address, folder):
    """The contents of a dataset at an address."""
    system, root = fsspec.core.url_to_fs(address)
    for name in system.find(root):
        path = folder / name.removeprefix(root).lstrip("/")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(system.cat_file(name))
    return contents(folder)


def left_in_workspaces():
    root = remote.Path(remote.tempfile.gettempdir())
    return [path for path in root.rglob("*") if path.parent != root]


def test_what_a_place_is():
    assert isinstance(storage_of("s3://bucket/set"), RemoteFolder)
    for place in ("data/set", "file:///mnt/a%20disk/set"):
        assert isinstance(storage_of(place), LocalFolder)
    assert str(storage_of("file:///mnt/a%20disk/set").place) == "/mnt/a disk/set"
    with pytest.raises(SynthdepthError, match="nonsense://x cannot be used: Protocol not known"):
        render("nonsense://x")


def test_an_address_gets_the_bytes_of_a_folder(local, address, tmp_path):
    report = render(address)
    assert (report.folder, report.rendered) == (address, PAIRS)
    assert fetched(address, tmp_path) == local
    assert left_in_workspaces() == []
    # And nothing is rendered, nor read of the shards but by the card, to find it whole.
    assert render(address).rendered == 0
    assert [s.key for s in PairDataset(address)] == [s.key for s in PairDataset(str(tmp_path))]


def test_a_dataset_at_an_address_is_extended(local, address, tmp_path):
    first = render(address, pairs=4)
    second = render(address)
    assert (first.rendered, second.rendered) == (4, PAIRS - 4)
    assert fetched(address, tmp_path) == local


class Killed(BaseException):
    pass


def test_killed_at_any_object_it_goes_on_to_the_same_bytes(local, address, tmp_path, monkeypatch):
    put, died_at = MemoryFileSystem.put_file, []
    for number in itertools.count(1):
        puts = itertools.count(1)

        def dying(self, path, name, *, puts=puts, number=number, **more):
            put(self, path, name, **more)
            if next(puts) == number:
                raise Killed(name)

        MemoryFileSystem.store.clear()
        monkeypatch.setattr(MemoryFileSystem, "put_file", dying)
        try:
            render(address)
            break
        except Killed as death:
            died_at.append(str(death).removeprefix("/bucket/set/"))
        monkeypatch.setattr(MemoryFileSystem, "put_file", put)
        render(address)
        assert fetched(address, tmp_path / str(number)) == local
    assert died_at[0] == died_at[-1] == MANIFEST
    assert len({*died_at}) == len(local)


def faulty(monkeypatch, name, faults):
    """Have an operation of the file system in memory fail as listed, None for not."""
    operation, faults, calls = getattr(MemoryFileSystem, name), iter(faults), []

    def fail_first(self, *arguments, **options):
        calls.append(arguments)
        fault = next(faults, None)
        if fault is not None:
            raise fault
        return operation(self, *arguments, **options)

    monkeypatch.setattr(MemoryFileSystem, name, fail_first)
    return calls


def test_faults_of_the_network_change_nothing(local, address, tmp_path, monkeypatch):
    refused, server = ConnectionRefusedError("refused"), OSError(5, "Internal Server Error")
    faulty(monkeypatch, "put_file", [refused, None, server, server, refused, None] * 4)
    faulty(monkeypatch, "find", [server, refused])
    faulty(monkeypatch, "get_file", [refused, None, server])
    render(address, pairs=4)
    render(address)
    assert fetched(address, tmp_path) == local


def test_what_arrives_cut_off_is_sent_again(local, address, tmp_path, monkeypatch):
    put, puts = MemoryFileSystem.put_file, itertools.count()

    def cut(self, path, name, **more):
        put(self, path, name, **more)
        if next(puts) % 3 == 0:
            self.store[self._strip_protocol(name)].truncate(100)

    monkeypatch.setattr(MemoryFileSystem, "put_file", cut)
    render(address)
    assert fetched(address, tmp_path) == local


@pytest.mark.parametrize(
    ("fault", "tries"), [(ConnectionResetError("reset by peer"), 7), (PermissionError("no"), 1)]
)
def test_a_network_that_stays_away_ends_the_run_with_one_line(address, monkeypatch, fault, tries):
    calls = faulty(monkeypatch, "put_file", [None, None, *[fault] * 100])
    with pytest.raises(DatasetError, match=f"{fault}; the 3 pairs of finished shards are safe"):
        render(address)
    assert len(calls) == 2 + tries
    assert left_in_workspaces() == []


def test_an_address_without_an_answer_is_told_at_once(address, monkeypatch):
    calls = faulty(monkeypatch, "info", [ConnectionRefusedError("refused")])
    with pytest.raises(DatasetError, match=r"memory://bucket/set: dataset.json .*: refused"):
        render(address)
    assert len(calls) == 1


def test_other_things_at_an_address_are_not_touched(address):
    system = fsspec.filesystem("memory")
    system.pipe_file("/bucket/set/thesis.tex", b"precious")
    with pytest.raises(DatasetError, match=r"holds 'thesis.tex' and no dataset"):
        render(address)
    assert system.find("/bucket") == ["/bucket/set/thesis.tex"]


def test_a_shard_that_went_from_an_address_is_told(address, monkeypatch):
    def lose(job, recipe, folder, progress):
        if job.scene_index == 2:
            fsspec.filesystem("memory").rm_file("/bucket/set/train/blocks-train-000000.tar")
        return made_shard(job, recipe, folder, progress)

    without_rendering(monkeypatch, lose)
    with pytest.raises(DatasetError, match="blocks-train-000000.tar was deleted or changed"):
        render(address)
    without_rendering(monkeypatch)
    assert render(address).rendered == 3


def test_a_shard_cut_off_at_an_address_is_rendered_again(local, address, tmp_path):
    render(address)
    for size in (20_000, 10_240):
        MemoryFileSystem.store["/bucket/set/train/blocks-train-000000.tar"].truncate(size)
        assert render(address).rendered == 3
    assert fetched(address, tmp_path) == local


# Folders


def test_a_folder_takes_one_run_at_a_time(tmp_path):
    refused = pytest.raises(DatasetError, match="another run is writing to")
    with LocalFolder(tmp_path).locked(), refused:
        render(tmp_path)
    render(tmp_path)


def test_half_written_files_are_swept_and_those_of_others_are_not(tmp_path):
    folder = LocalFolder(tmp_path)
    ours = [partial_of(tmp_path / name) for name in (MANIFEST, "train/a.tar", "test/b.tar")]
    theirs = [tmp_path / "film.mkv.1.partial", tmp_path / "train" / "notes.partial"]
    for path in (*ours, *theirs):
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"?")
    assert folder.files() == {"film.mkv.1.partial": 1}
    with folder.swept():
        assert not any(path.exists() for path in ours)
        ours[0].touch()
    assert not ours[0].exists()
    assert all(path.exists() for path in theirs)


def test_a_folder_without_its_manifest_is_gone(tmp_path):
    folder = LocalFolder(tmp_path / "set")
    with pytest.raises(GoneError, match="deleted, moved or unmounted"):
        folder.check()
    render(folder.place)
    folder.check()


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(DatasetError, match="cannot write .*Not a directory"):
        render(tmp_path / "file" / "set")


# Workspaces


def test_workspaces_of_the_dead_are_removed_and_those_of_the_living_are_not():
    with _own_workspace() as living:
        abandoned = living.parent / "abandoned"
        abandoned.mkdir()
        (abandoned / "half.tar").touch()
        with _own_workspace() as other:
            assert not abandoned.exists()
            assert living.exists() and other.exists() and other != living
        assert living.exists() and not other.exists()
    assert left_in_workspaces() == []


# S3, for real


_ERROR = b"HTTP/1.1 500 Internal Server Error\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


class FaultyProxy(socketserver.ThreadingTCPServer):
    """Stands before a server, and answers some connections with an error or not at all."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, port):
        super().__init__(("127.0.0.1", 0), _Relay)
        self.port, self.count, self.faults = port, itertools.count(1), 0


class _Relay(socketserver.BaseRequestHandler):
    def handle(self):
        number = next(self.server.count)
        if number % 5 == 0:
            self.server.faults += 1
            return  # Closed without a word.
        if number % 7 == 0:
            self.server.faults += 1
            self.request.recv(65536)
            self.request.sendall(_ERROR)
            return
        with socket.create_connection(("127.0.0.1", self.server.port)) as server:
            back = threading.Thread(target=_copy, args=(server, self.request))
            back.start()
            _copy(self.request, server)
            back.join()


def _copy(source, target):
    try:
        while data := source.recv(65536):
            target.sendall(data)
        target.shutdown(socket.SHUT_WR)
    except OSError:
        pass


@pytest.fixture
def bucket(monkeypatch):
    """A bucket of an S3 server on this machine that has faults; gives address and proxy."""
    pytest.importorskip("s3fs", reason="needs s3fs")
    server = pytest.importorskip("moto.server", reason="needs moto[server]")
    moto = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    moto.start()
    port = moto.get_host_and_port()[1]
    proxy = FaultyProxy(port)
    threading.Thread(target=proxy.serve_forever, daemon=True).start()
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "test")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "test")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
    plain = fsspec.filesystem("s3", skip_instance_cache=True)
    plain.mkdir("bucket")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{proxy.server_address[1]}")
    fsspec.get_filesystem_class("s3").clear_instance_cache()
    yield "s3://bucket/set", proxy, plain
    fsspec.get_filesystem_class("s3").clear_instance_cache()
    proxy.shutdown()
    proxy.server_close()
    moto.stop()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_bucket_with_faults_gets_the_bytes_of_a_folder(local, bucket, tmp_path, monkeypatch):
    address, proxy, plain = bucket

    def stopping(function, jobs, workers, patience_s):
        events = in_this_process(function, jobs, workers, patience_s=patience_s)
        yield from itertools.islice(events, 5)
        raise KeyboardInterrupt

    without_rendering(monkeypatch, run_jobs=stopping)
    with pytest.raises(KeyboardInterrupt):
        render(address)
    without_rendering(monkeypatch)
    report = render(address)
    assert 0 < report.rendered < PAIRS
    assert proxy.faults > 3
    for name in plain.find("bucket/set"):
        path = tmp_path / os.path.relpath(name, "bucket/set")
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(plain.cat_file(name))
    assert contents(tmp_path) == local
    assert read_manifest(tmp_path)["complete"]
    # The loaders read it where it is.
    assert len([sample.key for sample in PairDataset(address)]) == PAIRS
