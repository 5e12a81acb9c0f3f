"""Files as they come from outside: regular ones only, of a bounded size, inside their folder.

Where functions take them, `error` is the kind of error that is raised, `path` or `where` is named in its message, and
`what` begins it ("the camera file").
"""
