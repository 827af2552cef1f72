"""Copies a Mitsuba scene with another film, of the given size and with the given filter, and with absolute file
paths.

    python3 validation/peers/prepare_scene.py SCENE.xml OUT.xml WIDTHxHEIGHT FILTER

The sampler's type becomes the parameter `sampler` (independent by default), which renderers with several
samplers can set. All renderers of a comparison then render the same pixels, and with the filter `box` none
correlates them.
"""
import sys
import xml.etree.ElementTree as xml
from pathlib import Path


def replace(element, kind, name, value):
    for child in [c for c in element if c.get("name") == name]:
        element.remove(child)
    xml.SubElement(element, kind, name=name, value=str(value))


def main():
    source, out, size, reconstruction = Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:]
    tree = xml.parse(source)
    root = tree.getroot()
    defaults = {d.get("name"): d.get("value") for d in root.findall("default")}
    for text in root.iter("string"):
        if text.get("name") == "filename":
            value = text.get("value")
            for name, default in sorted(defaults.items(), reverse=True):
                value = value.replace(f"${name}", default)
            text.set("value", str((source.parent / value).resolve()))
    for film in root.iter("film"):
        width, height = size.split("x")
        replace(film, "integer", "width", width)
        replace(film, "integer", "height", height)
        for child in film.findall("rfilter"):
            film.remove(child)
        xml.SubElement(film, "rfilter", type=reconstruction)
    for sensor in root.iter("sensor"):
        for sampler in sensor.findall("sampler"):
            sensor.remove(sampler)
        sampler = xml.SubElement(sensor, "sampler", type="$sampler")
        xml.SubElement(sampler, "integer", name="sample_count", value="16")
    # Unused parameters would be errors.
    text = "".join(value for element in root.iter() for value in element.attrib.values())
    for default in root.findall("default"):
        if f"${default.get('name')}" not in text:
            root.remove(default)
    root.insert(0, xml.Element("default", name="sampler", value="independent"))
    tree.write(out, encoding="utf-8", xml_declaration=True)


if __name__ == "__main__":
    main()
