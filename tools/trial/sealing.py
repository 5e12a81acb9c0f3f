"""Seals: the hash of a label and a secret, published before the engine runs."""

import hashlib
import json
import secrets
from typing import Any


def sealed(label: dict[str, Any]) -> tuple[str, str]:
    """SHA-256 of the label followed by its salt, and the salt."""
    salt = secrets.token_hex(16)
    return digest(label, salt), salt


def digest(label: dict[str, Any], salt: str) -> str:
    text = json.dumps(label, sort_keys=True) + salt
    return hashlib.sha256(text.encode("utf-8")).hexdigest()
