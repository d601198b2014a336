"""The JSON schema of a scene: pendpin schema."""


def schema() -> None:
    """Print the JSON schema of a scene, for editors that complete and check TOML."""
    from json import dumps

    from pendpin.scene import Scene

    print(dumps(Scene.model_json_schema(), indent=2))
