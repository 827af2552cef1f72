"""Renders a scene with one variant of Mitsuba 3 and prints the time it took.

    python3 validation/peers/mitsuba_render.py VARIANT SCENE.xml OUT.exr SPP SEED THREADS [SAMPLER]

The last line is {"seconds": s, "startup": t, "cpu_seconds": c}; SAMPLER is the value of the scene's parameter
`sampler`. Loading counts as start-up, and so does a first picture, for which a compiled variant compiles. It
has the same number of samples, because that number is a constant in the kernels.
"""
import json
import sys
import time


def main():
    variant, path, out, spp, seed, threads, *sampler = sys.argv[1:]
    start = time.perf_counter()
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(variant)
    # Otherwise the colour code of a warning would precede the last line and make it unreadable.
    mi.set_log_level(mi.LogLevel.Error)
    if int(threads) > 0:
        dr.set_thread_count(int(threads))
    scene = mi.load_file(path, **({"sampler": sampler[0]} if sampler else {}))

    def render(count, number):
        image = mi.render(scene, spp=count, seed=number)
        dr.eval(image)
        dr.sync_thread()

    render(int(spp), int(seed) ^ 1)
    ready, busy = time.perf_counter(), time.process_time()
    render(int(spp), int(seed))
    done, cpu = time.perf_counter(), time.process_time() - busy
    # The film has the same picture with the names of its channels, including those of the integrator.
    scene.sensors()[0].film().bitmap(raw=False).write(out)
    print(json.dumps({"seconds": done - ready, "startup": ready - start, "cpu_seconds": cpu}))


if __name__ == "__main__":
    main()
