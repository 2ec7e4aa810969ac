// SPDX-License-Identifier: Apache-2.0
//
// Made smoke128.zip.nvdb from smoke128_zyx.npy (float32, 128^3, axes z y x, 128 bytes of header): every cell is active, the
// one with indices (i, j, k) has its middle at ((i, j, k) + 1/2) / 128. Lossless. Needs NanoVDB (Debian: libnanovdb-dev);
// not part of the build.
//   g++ -std=c++17 -O1 -DNANOVDB_USE_ZIP make_smoke128.cc -lz -o make_smoke128 && ./make_smoke128 smoke128_zyx.npy
#include <cstdio>
#include <fstream>
#include <vector>

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

int main(int argc, char** argv) {
    const int n = 128;
    std::vector<float> cells(size_t(n) * n * n);
    std::ifstream file(argc > 1 ? argv[1] : "smoke128_zyx.npy", std::ios::binary);
    file.seekg(128);
    if (!file.read(reinterpret_cast<char*>(cells.data()), std::streamsize(cells.size() * 4))) return 1;
    nanovdb::GridBuilder<float> builder(0.0f, nanovdb::GridClass::FogVolume);
    auto accessor = builder.getAccessor();
    double sum = 0;
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) {
                float value = cells[(size_t(k) * n + j) * n + i];
                accessor.setValue(nanovdb::Coord(i, j, k), value);
                sum += value;
            }
    auto handle = builder.getHandle<>(1.0 / n, nanovdb::Vec3d(0.5 / n), "density");
    std::printf("%llu active, sum %.17g, cell (64, 64, 40) %.9g\n",
                (unsigned long long)handle.grid<float>()->activeVoxelCount(), sum,
                handle.grid<float>()->tree().getValue(nanovdb::Coord(64, 64, 40)));
    nanovdb::io::writeGrid("smoke128.zip.nvdb", handle, nanovdb::io::Codec::ZIP);
    return 0;
}
