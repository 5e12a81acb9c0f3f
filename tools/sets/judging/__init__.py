"""What two judges share: running `fusion` as a user does, writing recordings, reading what was said and measured."""
