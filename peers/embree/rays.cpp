// The any-hit rate of Embree on triangles and segments in files: rays FOLDER NAME [medium], the last for a tree without spatial splits.
// Reads NAME.tri, NAME.volume, NAME.surface and the answers NAME.*.ours of `cargo run -p zonal-benches --bin any_hit`.
#include <embree3/rtcore.h>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <ctime>
#include <vector>

static std::vector<double> doubles(const std::string &path) {
    std::ifstream in(path, std::ios::binary);
    std::vector<char> b((std::istreambuf_iterator<char>(in)), {});
    const double *d = reinterpret_cast<const double *>(b.data());
    return {d, d + b.size() / 8};
}

static double cpu() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int argc, char **argv) {
    if (argc < 3) return std::fprintf(stderr, "rays FOLDER NAME [medium]\n"), 2;
    const std::string base = std::string(argv[1]) + "/" + argv[2];
    const std::vector<double> corners = doubles(base + ".tri");
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, argc > 3 ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t n = corners.size() / 9;
    float *v = static_cast<float *>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * n));
    unsigned *index = static_cast<unsigned *>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, n));
    for (size_t i = 0; i < 9 * n; i++) v[i] = static_cast<float>(corners[i]);
    for (size_t i = 0; i < 3 * n; i++) index[i] = i;
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcCommitScene(scene);
    for (const char *kind : {"volume", "surface"}) {
        const std::vector<double> s = doubles(base + "." + kind);
        const size_t count = s.size() / 6;
        std::vector<uint8_t> answers(count);
        double best = 1e300;
        for (int repeat = 0; repeat < 5; repeat++) {
            const double start = cpu();
            for (size_t i = 0; i < count; i++) {
                const double *p = &s[6 * i];
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                RTCRay ray{};
                ray.org_x = p[0], ray.org_y = p[1], ray.org_z = p[2];
                ray.dir_x = p[3] - p[0], ray.dir_y = p[4] - p[1], ray.dir_z = p[5] - p[2];
                // In single precision an end that lies on a triangle needs this much air.
                ray.tnear = 1e-5f, ray.tfar = 1 - 1e-5f, ray.mask = -1;
                rtcOccluded1(scene, &context, &ray);
                answers[i] = ray.tfar < 0;
            }
            best = std::min(best, cpu() - start);
        }
        std::ofstream(base + "." + kind + ".embree", std::ios::binary)
            .write(reinterpret_cast<const char *>(answers.data()), count);
        std::ifstream in(base + "." + kind + ".ours", std::ios::binary);
        std::vector<char> ours((std::istreambuf_iterator<char>(in)), {});
        size_t blocked = 0, ours_alone = 0, peer_alone = 0;
        for (size_t i = 0; i < count; i++) {
            blocked += answers[i];
            if (i < ours.size()) ours_alone += ours[i] && !answers[i], peer_alone += !ours[i] && answers[i];
        }
        std::printf("embree %-8s %-8s %6.3f M/s  %zu blocked; blocked for us alone %zu, for embree alone %zu of %zu\n",
                    argv[2], kind, count / best * 1e-6, blocked, ours_alone, peer_alone, count);
    }
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
