# SPDX-License-Identifier: GPL-3.0-or-later
"""The moving pictures of the site: the repository has animated WebP, which a forge shows; the site has MP4, which a
reader can stop. Needs Pillow and ffmpeg; without them the WebP stays."""
from __future__ import annotations

import re
import shutil
import subprocess
from html import escape
from pathlib import Path

try:
    from PIL import Image, ImageSequence
except ImportError:
    Image = None

CLIP = re.compile(r"^!\[([^\]]+)\]\(((?:\.\./)*)pictures/(clip_\w+)\.webp\)$", re.M)  # words, the way up, name
FOLDER = "_static/clips"


def with_videos(text: str, pictures: Path, site: Path) -> str:
    """A page of the site, each of its clips (a line of its own) as a video that is made in FOLDER of the site once."""
    def video(found: re.Match[str]) -> str:
        words, up, name = found.groups()
        size = made(pictures / f"{name}.webp", site / FOLDER)
        if size is None:
            return found[0]
        place = f"{up}{FOLDER}/{name}"
        return (f'<video controls muted loop playsinline preload="none" width="{size[0]}" height="{size[1]}" '
                f'aria-label="{escape(words)}" poster="{place}.jpg" src="{place}.mp4"></video>')
    return CLIP.sub(video, text)


def made(clip: Path, folder: Path) -> tuple[int, int] | None:
    """An animated WebP as MP4, its first frame as JPEG. Returns width and height in pixels, even as H.264 wants them;
    None where the tools are missing."""
    if Image is None or not shutil.which("ffmpeg"):
        return None
    with Image.open(clip) as pictures:
        width, height = (side // 2 * 2 for side in pictures.size)
        video, poster = (folder / f"{clip.stem}.{ending}" for ending in ("mp4", "jpg"))
        if video.is_file():
            return width, height
        frames, shown = [], []  # RGB, and how long: the writer of WebP has one picture of several that are alike
        for picture in ImageSequence.Iterator(pictures):
            frames.append(picture.convert("RGB").crop((0, 0, width, height)))
            shown.append(picture.info["duration"])
    step = min(shown)  # milliseconds
    pixels = b"".join(frame.tobytes() * round(time / step) for frame, time in zip(frames, shown))
    folder.mkdir(parents=True, exist_ok=True)
    frames[0].save(poster, quality=80)
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{1000.0 / step:g}", "-i", "-"]
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", *raw, "-pix_fmt", "yuv420p", "-crf", "25",
                    "-movflags", "+faststart", str(video)], input=pixels, check=True)
    return width, height
