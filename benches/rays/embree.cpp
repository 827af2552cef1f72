// Replays recorded rays with Embree 3 or 4: the twin of `rays replay` (replay.rs), with the same questions and answers.
//
//     g++ -O3 -march=native -o rays-embree benches/rays/embree.cpp -ldl
//     ./rays-embree LIBRARY FOLDER MESH fast|robust [ISA] [THREADS]
//
// The library is opened at run time and the few declarations that both versions share are repeated here (from the API
// documentation), so no headers are needed and one program serves either version. Build quality is HIGH, one ray at a time.

#include <dlfcn.h>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

typedef void *Device, *Scene, *Mesh;
struct alignas(16) Ray {
    float origin[3], start, direction[3], time, end;
    unsigned mask, id, flags;
};
struct alignas(16) RayHit {
    Ray ray;
    float normal[3], u, v;
    // Version 4 may be built with arrays of instances, and then writes one number more.
    unsigned primitive, geometry, instance, room[8];
};
// Version 3's context, without a filter; version 4 takes optional arguments in its place.
struct Context {
    int flags;
    void *filter;
    unsigned instance;
    float width;
};
struct Record {
    float origin[3], start, direction[3], end;
};
struct Hit {
    double t;
    uint64_t primitive;
};

static void *library;

template <class Function> Function *symbol(const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "no %s in the library\n", name);
        exit(1);
    }
    return reinterpret_cast<Function *>(found);
}

static std::vector<char> bytes(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        fprintf(stderr, "cannot read %s\n", path.c_str());
        exit(1);
    }
    return {std::istreambuf_iterator<char>(file), {}};
}

static double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

static long in_use = 0;
static bool count_bytes(void *, ssize_t bytes, bool) {
    __atomic_add_fetch(&in_use, bytes, __ATOMIC_RELAXED);
    return true;
}

int main(int argc, char **argv) {
    if (argc < 5) {
        fprintf(stderr, "usage: rays-embree LIBRARY FOLDER MESH fast|robust [ISA] [THREADS]\n");
        return 1;
    }
    library = dlopen(argv[1], RTLD_NOW | RTLD_GLOBAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    const std::string base = std::string(argv[2]) + "/" + argv[3];
    const bool robust = std::string(argv[4]) == "robust";
    std::string settings = std::string("threads=") + (argc > 6 ? argv[6] : "1");
    if (argc > 5) settings += std::string(",isa=") + argv[5];

    const std::vector<char> file = bytes(base + ".mesh");
    const uint32_t *counts = reinterpret_cast<const uint32_t *>(file.data());
    const float *positions = reinterpret_cast<const float *>(counts + 2);
    const uint32_t *triangles = reinterpret_cast<const uint32_t *>(positions + 3 * size_t(counts[0]));

    const Device device = symbol<Device(const char *)>("rtcNewDevice")(settings.c_str());
    const long version = symbol<ssize_t(Device, int)>("rtcGetDeviceProperty")(device, 0);
    symbol<void(Device, bool (*)(void *, ssize_t, bool), void *)>("rtcSetDeviceMemoryMonitorFunction")(
        device, count_bytes, nullptr);
    const Scene scene = symbol<Scene(Device)>("rtcNewScene")(device);
    const int ROBUST = 1 << 2, HIGH = 2, TRIANGLES = 0, INDEX = 0, VERTEX = 1, UINT3 = 0x5003, FLOAT3 = 0x9003;
    if (robust) symbol<void(Scene, int)>("rtcSetSceneFlags")(scene, ROBUST);
    symbol<void(Scene, int)>("rtcSetSceneBuildQuality")(scene, HIGH);
    const Mesh mesh = symbol<Mesh(Device, int)>("rtcNewGeometry")(device, TRIANGLES);
    symbol<void(Mesh, int)>("rtcSetGeometryBuildQuality")(mesh, HIGH);
    auto buffer = symbol<void(Mesh, int, unsigned, int, const void *, size_t, size_t, size_t)>(
        "rtcSetSharedGeometryBuffer");
    // The file goes on after the vertices, as sixteen-byte loads of the last need; the triangles are its end.
    buffer(mesh, VERTEX, 0, FLOAT3, positions, 0, 12, counts[0]);
    buffer(mesh, INDEX, 0, UINT3, triangles, 0, 12, counts[1]);
    symbol<void(Mesh)>("rtcCommitGeometry")(mesh);
    symbol<unsigned(Scene, Mesh)>("rtcAttachGeometry")(scene, mesh);
    const double start = seconds();
    symbol<void(Scene)>("rtcCommitScene")(scene);
    const double built = seconds() - start;
    printf("{\"version\": %ld, \"triangles\": %u, \"build_seconds\": %.6f, \"bytes\": %ld}\n", version, counts[1], built,
           in_use);
    fflush(stdout);

    Context context = {0, nullptr, ~0u, 0.0f};
    void *const with = version / 10000 == 3 ? &context : nullptr;
    // The second and third arguments are exchanged between the versions.
    auto call = symbol<void(Scene, void *, void *)>("rtcIntersect1");
    auto call_any = symbol<void(Scene, void *, void *)>("rtcOccluded1");
    auto load = [](const Record &r) {
        return Ray{{r.origin[0], r.origin[1], r.origin[2]},          r.start, {r.direction[0], r.direction[1], r.direction[2]},
                   0.0f, r.end, ~0u, 0, 0};
    };
    auto closest = [&](const Record &record) {
        RayHit one;
        one.ray = load(record);
        one.geometry = one.instance = ~0u;
        with ? call(scene, with, &one) : call(scene, &one, nullptr);
        return one.geometry == ~0u ? Hit{std::numeric_limits<double>::infinity(), ~0ull}
                                   : Hit{one.ray.end, one.primitive};
    };
    auto occluded = [&](const Record &record) {
        Ray ray = load(record);
        with ? call_any(scene, with, &ray) : call_any(scene, &ray, nullptr);
        return ray.end < 0.0f;
    };
    std::map<std::string, std::vector<char>> sets;
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::string question, kind, path;
        words >> question >> kind >> path;
        if (!sets.count(kind)) sets[kind] = bytes(base + "-" + kind + ".rays");
        const Record *rays = reinterpret_cast<const Record *>(sets[kind].data());
        const size_t count = sets[kind].size() / sizeof(Record);
        size_t met = 0;
        const double start = seconds();
        if (question == "occluded") {
            for (size_t i = 0; i < count; i++) met += occluded(rays[i]);
        } else {
            for (size_t i = 0; i < count; i++) met += closest(rays[i]).primitive != ~0ull;
        }
        printf("{\"seconds\": %.6f, \"rays\": %zu, \"met\": %zu}\n", seconds() - start, count, met);
        fflush(stdout);
        if (question == "hits") {
            std::ofstream out(path, std::ios::binary);
            for (size_t i = 0; i < count; i++) {
                const Hit hit = closest(rays[i]);
                out.write(reinterpret_cast<const char *>(&hit), sizeof hit);
            }
        }
    }
}
