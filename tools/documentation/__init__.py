"""What the documentation site is made with, beside Sphinx: `docs/conf.py` names each file here as an extension."""
