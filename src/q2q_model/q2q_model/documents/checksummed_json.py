"""JSON files of data with format, version and a SHA-256 checksum over the other entries.

The checksum detects a truncated, edited or damaged file. Nothing in such a file is executed.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass

from q2q_model.documents.plain_values import Plain

LONGEST = 16_000_000
"""Longest text that is read [characters]: a model also arrives on a topic, and its node waits meanwhile."""


class ChecksummedFileError(ValueError):
    """Error for a file of another format, of an unknown version, or damaged."""


@dataclass(frozen=True, slots=True)
class FileFormat:
    """Kind of a file."""

    name: str
    """Entry "format" of the file."""
    noun: str
    """Contents, in messages."""
    version: int
    """Version that is written; those from 1 on are read."""
    maker: str
    """Command that creates such files, in messages."""


def encode_checksummed(body: Mapping[str, Plain], form: FileFormat) -> str:
    """Return the text of a file with these entries."""
    whole = {"format": form.name, "version": form.version, **body}
    return json.dumps(whole | {"checksum": checksum(whole)}, indent=1) + "\n"


def decode_checksummed(text: str, form: FileFormat) -> dict[str, Plain]:
    """Return the entries of a file's text, without the checksum.

    Raises:
        ChecksummedFileError: too long, not JSON, another format or version, or a wrong checksum.
    """
    if len(text) > LONGEST:
        raise ChecksummedFileError(f"{len(text)} characters; must be at most {LONGEST}")
    try:
        body = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ChecksummedFileError(
            f"not complete JSON ({error}); create it again with {form.maker}"
        ) from error
    if not isinstance(body, dict) or body.get("format") != form.name:
        raise ChecksummedFileError(f'not a {form.noun}: entry "format" should be "{form.name}"')
    if body.get("version") not in range(1, form.version + 1):
        versions = "version 1" if form.version == 1 else f"versions 1 to {form.version}"
        raise ChecksummedFileError(
            f"version {body.get('version')!r} is unknown: this program reads {versions}"
        )
    found = body.pop("checksum", None)
    if found != checksum(body):
        raise ChecksummedFileError(
            "the checksum does not match: the file was edited or damaged; create it again"
        )
    return body


def checksum(body: Mapping[str, object]) -> str:
    """Return the checksum over entries; raise ChecksummedFileError if they are nested too deeply."""
    try:
        canonical = json.dumps(body, sort_keys=True, separators=(",", ":"))
    except RecursionError as error:
        raise ChecksummedFileError("the entries are nested too deeply") from error
    return hashlib.sha256(canonical.encode()).hexdigest()
