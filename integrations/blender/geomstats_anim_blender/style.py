"""The metric of an armature: custom properties of its pose bones, and JSON that USD files carry."""

import json
import math

from bpy.utils import flip_name

SCHEMES = ("constant", "linear", "slerp", "squad", "rotation-spline", "geodesic", "geodesic-spline", "learned")
DEFAULT_SCHEME = "geodesic-spline"
LEARNED = "learned"
WITH_METRIC = ("geodesic", "geodesic-spline", LEARNED)
BENT = ("geodesic-spline", LEARNED)
"""Schemes that have a tension."""

KEY = "geodesicMetric"
"""Custom property of the object and of its armature: the metric's JSON."""

SUMMARY = f"{KEY}Summary"
LARGEST = 1 << 26
"""Characters of a metric's JSON."""

_HUGE = 1e300
"""Numbers of a metric are smaller."""

SIDES = ("left", "right")

_RANGES = {
    "alpha": {"min": 1e-2, "max": 1e2, "soft_min": 0.1, "soft_max": 10.0, "default": 1.0},
    "beta": {"min": 1e-2, "max": 1e2, "soft_min": 0.1, "soft_max": 10.0, "default": 1.0},
    "tension": {"min": 0.0, "max": 2.0, "default": 1.0},
    "translation_tension": {"min": 0.0, "max": 2.0, "default": 1.0},
    "axes": {"subtype": "EULER", "soft_min": -math.pi, "soft_max": math.pi},
    "side": {"default": "left"},
}
NAMES = tuple(_RANGES)
_WORDS = {
    "alpha": "alpha",
    "beta": "beta",
    "tension": "tension",
    "translation_tension": "translationTension",
    "axes": "axes",
    "side": "invariance",
}
"""Names that the JSON has for them."""


class StyleError(Exception):
    """Error that one sentence says."""


def property_of(name):
    """Return the name of the custom property of a pose bone."""
    return f"geodesic_{name}"


def scheme_of(armature):
    """Return the scheme of an armature: as set, else that of its metric, else the default."""
    if armature.geodesic.chosen_scheme in SCHEMES:
        return armature.geodesic.chosen_scheme
    document = stored(armature)
    return DEFAULT_SCHEME if document is None else document["scheme"]


DEFAULTS = {
    "alpha": 1.0,
    "beta": 1.0,
    "tension": 1.0,
    "translation_tension": 1.0,
    "side": "left",
    "axes": (0.0, 0.0, 0.0),
}
"""Style of a bone that nobody has styled; schemes that are not bent do not ask for tensions."""


def value(bone, name):
    """Return a setting of a pose bone: its custom property, else what the armature's metric says, else the default."""
    key, armature = property_of(name), bone.id_data
    if key in bone:
        own = bone[key]
        return tuple(own) if name == "axes" else str(own) if name == "side" else float(own)
    document = stored(armature)
    place = None if document is None else _places(document, armature).get(bone.name)
    if place is not None and not (name.endswith("tension") and not _fits(document, armature)):
        values = document[_WORDS[name]]
        if values is not None:
            return tuple(values[place]) if name == "axes" else values[place]
    return DEFAULTS[name]


def _fits(document, armature):
    """Return whether the tensions of a metric are those of the armature's scheme."""
    scheme = scheme_of(armature)
    return document["scheme"] == scheme or {document["scheme"], scheme} <= set(BENT)


def set_value(bone, name, new):
    """Set a custom property of a pose bone, with its range."""
    key = property_of(name)
    bone[key] = list(map(float, new)) if name == "axes" else str(new) if name == "side" else float(new)
    bone.id_properties_ui(key).update(description=f"Geodesic in-betweens: {name.replace('_', ' ')}", **_RANGES[name])


def is_styled(armature):
    """Return whether a bone has a setting of its own."""
    return any(property_of(name) in bone for bone in armature.pose.bones for name in NAMES)


def clear(bones):
    """Take the settings of bones away."""
    for bone in bones:
        for name in NAMES:
            bone.pop(property_of(name), None)


def edit(bone, name, new):
    """Set what a slider says, which has seven digits, for a bone and all that are selected with it."""
    if name == "axes":
        new = [float(f"{each:.7g}") for each in new]
    elif name != "side":
        new = float(f"{new:.7g}")
    for each in selected(bone):
        set_value(each, name, new)
    store(bone.id_data)


def reset(bones):
    """Give bones the metric that bends nothing, and the usual tension."""
    for bone in bones:
        for name in NAMES:
            set_value(bone, name, DEFAULTS[name])


def changed(armature):
    """Do what follows a change of custom properties."""
    store(armature)
    armature.update_tag()


def mirror(bones):
    """Give the counterparts of bones, by Blender's rules of names, the same settings as seen in a mirror.

    Returns the number of counterparts. Blender mirrors the turn (x, y, z) of a bone into (x, -y, -z).
    """
    n = 0
    for bone in bones:
        other = bone.id_data.pose.bones.get(flip_name(bone.name))
        if other is None or other == bone:
            continue
        for name in NAMES:
            own = value(bone, name)
            set_value(other, name, (own[0], -own[1], -own[2]) if name == "axes" else own)
        n += 1
    return n


def path_of(bone):
    """Return the path of a bone, as USD names joints."""
    return "/".join([*(parent.name for parent in reversed(bone.parent_recursive)), bone.name])


def bones_of(armature):
    """Return the pose bones, parents before children."""
    return sorted(armature.pose.bones, key=lambda bone: len(bone.parent_recursive))


def document_of(armature):
    """Return the metric of an armature as the document that geomstats-anim reads and writes."""
    bones, scheme, base = bones_of(armature), scheme_of(armature), stored(armature)
    places = {} if base is None else _places(base, armature)
    values = {name: [value(bone, name) for bone in bones] for name in NAMES}
    axes = [list(each) for each in values["axes"]]
    is_turned = any(any(each) for each in axes) or (base is not None and base["axes"] is not None)
    return {
        "format": KEY,
        "version": 1,
        "joints": [base["joints"][places[bone.name]] if bone.name in places else path_of(bone) for bone in bones],
        "alpha": values["alpha"],
        "beta": values["beta"],
        "axes": axes if is_turned else None,
        "invariance": values["side"],
        "tension": values["tension"],
        "translationTension": values["translation_tension"],
        "scheme": scheme,
        "quality": "",
        "provenance": {**({} if base is None else base["provenance"]), "edited": "Blender"},
    }


def stored(armature):
    """Return the metric that a USD import or an earlier edit has left as JSON, or None; what is no metric is none."""
    text = _text(armature)
    if text is None:
        return None
    if text not in _parsed:
        _parsed.clear()
        try:
            _parsed[text] = parse(text)
        except StyleError:
            _parsed[text] = None
    return _parsed[text]


def check(armature):
    """Refuse an armature whose JSON is no metric."""
    text = _text(armature)
    if text is not None and stored(armature) is None:
        try:
            parse(text)
        except StyleError as error:
            raise StyleError(f"{error} It is in {KEY} of {armature.name}; remove that custom property.") from error


def _text(armature):
    """Return the JSON of an armature, or None; older files had a line for people in its place."""
    texts = (holder.get(KEY) for holder in _holders(armature))
    return next((text for text in texts if isinstance(text, str) and text.lstrip().startswith("{")), None)


_parsed = {}
"""The last metric that was parsed, by its text."""


def _holders(armature):
    return (armature, armature.data)


def store(armature, document=None):
    """Write the metric's JSON where USD export takes it along; a metric that is there and still true stays as it is."""
    new, old = document or document_of(armature), stored(armature)
    if document is None and old is not None and _says_the_same(new, old, armature):
        return
    if document is None and old is None and not is_styled(armature):
        return
    text, sides = json.dumps(new, allow_nan=False), sorted(set(new["invariance"]))
    for holder in filter(lambda holder: holder.is_editable, _holders(armature)):
        holder[KEY] = text
        holder[SUMMARY] = f"{new['scheme']}, {len(new['joints'])} joints, {' and '.join(sides)}"


def _says_the_same(new, old, armature):
    """Compare two metrics joint by joint; joints that are no bones do not count, nor does where they come from."""
    places = _places(old, armature)
    if new["scheme"] != old["scheme"] or len(places) < len(new["joints"]):
        return False
    at = [old["joints"].index(joint) for joint in new["joints"]]
    for name in _WORDS.values():
        mine, others = new[name], old[name]
        if name == "axes":
            mine, others = (each or [[0.0] * 3] * len(all) for each, all in ((mine, at), (others, old["joints"])))
        if [each for each in mine] != [others[i] for i in at]:
            return False
    return True


def take(armature, document):
    """Make a metric that of an armature: JSON, scheme, and custom properties of the bones that it knows."""
    if not _places(document, armature):
        raise StyleError("The metric has an entry for no bone of this armature.")
    clear(armature.pose.bones)
    store(armature, document)
    armature.geodesic.chosen_scheme = document["scheme"]
    adopt(armature)


def adopt(armature):
    """Give bones without settings of their own those of the stored metric, as custom properties."""
    document = stored(armature)
    if document is None:
        return
    places = _places(document, armature)
    names = [name for name in NAMES if document["scheme"] in BENT or not name.endswith("tension")]
    for bone in armature.pose.bones:
        if bone.name in places:
            for name in names:
                if property_of(name) not in bone:
                    set_value(bone, name, value(bone, name))


def _places(document, armature):
    """Return the index of each bone's joint in a metric: by its path, else by its own name."""
    bones = tuple(armature.pose.bones.keys())
    if _found.get("document") is not document or _found["bones"] != bones:
        paths = {joint: i for i, joint in enumerate(document["joints"])}
        names = {}
        for joint, i in paths.items():
            names.setdefault(_identifier(joint.rsplit("/", 1)[-1]), []).append(i)
        places = {}
        for bone in armature.pose.bones:
            own = names.get(_identifier(bone.name), [])
            place = paths.get(path_of(bone), own[0] if len(own) == 1 else None)
            if place is not None:
                places[bone.name] = place
        _found.update(document=document, bones=bones, places=places)
    return _found["places"]


_found = {}
"""Places of the bones of the last armature in the last metric."""


def _identifier(name):
    """Return a name as USD writes it."""
    return "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in name)


def parse(text):
    """Read the JSON of a metric that somebody else may have written.

    Raises
    ------
    StyleError
        If it is none.
    """
    if len(text) > LARGEST:
        raise StyleError(f"The metric has {len(text)} characters; at most {LARGEST} are read.")
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise StyleError(f"The metric is not JSON: {error}.") from error
    if not isinstance(document, dict) or document.get("format") != KEY:
        raise StyleError(f'This JSON is not a metric: its "format" is not "{KEY}".')
    if document.get("version") != 1:
        raise StyleError(f"The metric has the version {document.get('version')}; this extension reads 1.")
    joints = document.get("joints")
    if not isinstance(joints, list) or not all(isinstance(joint, str) for joint in joints):
        raise StyleError("The metric has no list of joints.")
    if len(set(joints)) < len(joints):
        raise StyleError("The metric names a joint twice.")
    document.setdefault("translationTension", document.get("tension"))
    if not isinstance(document.setdefault("provenance", {}), dict):
        raise StyleError("The metric has a provenance that is no object.")
    if document.get("scheme") not in SCHEMES:
        raise StyleError(f"The metric has the scheme {document.get('scheme')!r}, which does not exist.")
    for name, word in _WORDS.items():
        values = document.get(word)
        if name == "axes" and values is None:
            document["axes"] = None
            continue
        if not isinstance(values, list) or len(values) != len(joints) or not all(_fit(name, each) for each in values):
            raise StyleError(
                f"The metric has no {word} for each of its {len(joints)} joints, or one that is not valid."
            )
    return document


def _fit(name, entry):
    if name == "side":
        return entry in SIDES
    if name == "axes":
        return isinstance(entry, list) and len(entry) == 3 and all(map(_is_number, entry))
    if not _is_number(entry):
        return False
    return 0.0 <= entry <= 2.0 if name.endswith("tension") else entry > 0.0


def _is_number(entry):
    return isinstance(entry, int | float) and not isinstance(entry, bool) and abs(entry) < _HUGE


def is_selected(bone):
    """Return whether a pose bone is selected, which Blender 5 asks the pose bone itself."""
    return bone.select if hasattr(bone, "select") else bone.bone.select


def selected(bone):
    """Return the bones that are edited with one: all selected ones of its armature if it is selected, else itself."""
    chosen = [each for each in bone.id_data.pose.bones if is_selected(each)]
    return chosen if bone in chosen else [bone]
