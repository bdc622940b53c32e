"""The published schema of campaign files accepts the shipped campaigns and refuses broken ones."""

import copy
import json
import pathlib
import sys

try:
    import jsonschema
    import yaml
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-jsonschema, python3-yaml)")
    sys.exit(77)

root = pathlib.Path(sys.argv[1])
schema = json.loads((root / "data/schema/campaign.schema.json").read_text())
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)

campaigns = sorted((root / "data/measurements").glob("*/campaign.yaml"))
assert campaigns, "no campaign is shipped"
for file in campaigns:
    validator.validate(yaml.safe_load(file.read_text()))

published = yaml.safe_load("""
kinetostat: 1
campaign: load cell
robot: ../robots/bench.yaml
units: {length: mm, force: N, angle: deg, time: s}
displacement: difference
readings: readings.csv
noise: {translation: 15 um}
""")
validator.validate(published)


def must_refuse(change):
    broken = copy.deepcopy(published)
    change(broken)
    assert not validator.is_valid(broken), broken


for key in ("kinetostat", "campaign", "units", "displacement", "readings"):
    must_refuse(lambda c: c.pop(key))
must_refuse(lambda c: c.update(kinetostat=2))
must_refuse(lambda c: c.update(displacement="relative"))
must_refuse(lambda c: c.update(nose={}))
must_refuse(lambda c: c["units"].pop("length"))
must_refuse(lambda c: c["noise"].update(translation=15))
must_refuse(lambda c: c["noise"].update(translation=["1 um", "2 um"]))
must_refuse(lambda c: c.update(zero="maybe"))
must_refuse(lambda c: c.update(wrench_point="tip"))
print(f"{len(campaigns)} campaigns agree with the schema")
