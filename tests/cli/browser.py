"""Pages as a browser shows them: screenshots by a headless Chromium."""

import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import zlib

BROWSER = os.environ.get("CONSIMD_CHROMIUM") or next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
MISSING = "needs Chromium (Debian's chromium: 122 MB to fetch, 414 MB installed); CONSIMD_CHROMIUM names another one"


def browse(page, *options, fragment="", width=1000, height=700):
    """Opens a page in Chromium, without network, WebGL drawn by software. Returns what that wrote, and what the page
    logged to its console."""
    with tempfile.TemporaryDirectory() as profile:
        # The sandbox does not start for root, as whom containers run; the pages are the caller's own.
        command = [
            BROWSER, "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", f"--user-data-dir={profile}",
            "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
            "--host-resolver-rules=MAP * ~NOTFOUND", f"--window-size={width},{height}", "--virtual-time-budget=3000",
            "--enable-logging=stderr", *options, page.resolve().as_uri() + fragment,
        ]  # fmt: skip
        ran = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    return ran, [line for line in ran.stderr.splitlines() if "CONSOLE" in line]


def take_screenshot(page, picture, fragment="", width=1000, height=700, options=()):
    """Writes what Chromium shows of a page to a PNG. Returns what the page logged to its console."""
    shot = f"--screenshot={picture}"
    ran, console = browse(page, shot, *options, fragment=fragment, width=width, height=height)
    if not picture.exists():
        raise AssertionError(f"Chromium took no screenshot: {ran.stderr[-2000:]}")
    return console


def screenshot(page, fragment="", height=700, options=()):
    """Rows of (r, g, b) that Chromium shows of a page, and what the page logged to its console."""
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "shot.png"
        console = take_screenshot(page, picture, fragment, height=height, options=options)
        return pixels(picture.read_bytes()), console


def document(page):
    """The HTML of a page once its scripts ran, and what it logged to its console."""
    ran, console = browse(page, "--dump-dom")
    if "</html>" not in ran.stdout:
        raise AssertionError(f"Chromium shows no document: {ran.stderr[-2000:]}")
    return ran.stdout, console


def pixels(png):
    """The rows of a PNG of 8 bits without interlacing, with or without alpha, each a list of (r, g, b)."""
    at, data = 8, b""
    while at < len(png):
        (length,), kind = struct.unpack(">I", png[at : at + 4]), png[at + 4 : at + 8]
        body = png[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            if depth != 8 or colour not in (2, 6) or interlaced:
                raise AssertionError("another kind of PNG")
        elif kind == b"IDAT":
            data += body
        at += 12 + length
    data = zlib.decompress(data)
    channels = 3 if colour == 2 else 4
    stride = channels * width
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind = data[y * (stride + 1)]
        line = bytearray(data[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for x in range(stride):
            left = line[x - channels] if x >= channels else 0
            corner = above[x - channels] if x >= channels else 0
            line[x] = (line[x] + predicted(kind, left, above[x], corner)) & 255
        rows.append([tuple(line[x : x + 3]) for x in range(0, stride, channels)])
        above = line
    return rows


def predicted(kind, left, up, corner):
    """The filters of PNG."""
    if kind == 0:
        return 0
    if kind == 1:
        return left
    if kind == 2:
        return up
    if kind == 3:
        return (left + up) // 2
    guess = left + up - corner
    return min((left, up, corner), key=lambda value: abs(guess - value))


def count(rows, is_wanted, first_column=0):
    """Pixels from a column on of a colour that `is_wanted(r, g, b)`."""
    return sum(is_wanted(*pixel) for row in rows for pixel in row[first_column:])
