"""After a configuration: what has changed is noticed, named and alone made new."""
