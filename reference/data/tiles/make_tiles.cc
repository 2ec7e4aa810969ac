// SPDX-License-Identifier: Apache-2.0
//
// Made tiles.zip.nvdb and printed what tests/io/volumes_table.h expects of it: a tree with active and inactive
// tiles of every size, negative coordinates, a background other than 0 and a full affine map, in every type that is
// read and some that are not. Needs OpenVDB and NanoVDB (Debian: libopenvdb-dev libnanovdb-dev); not part of the build.
//   g++ -std=c++17 -O1 -DNANOVDB_USE_OPENVDB -DNANOVDB_USE_ZIP make_tiles.cc -lopenvdb -ltbb -lz -lImath -o make_tiles
#include <openvdb/openvdb.h>

#include <cstdio>
#include <fstream>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

using openvdb::Coord;

static void fill(openvdb::FloatGrid& grid) {
    auto& tree = grid.tree();
    tree.addTile(3, Coord(-4096, 0, 0), 0.5f, true);      // 4096^3, active
    tree.addTile(3, Coord(0, -8192, 4096), 0.75f, false); // 4096^3, inactive, not the background
    tree.addTile(2, Coord(128, 256, 384), 1.25f, true);   // 128^3
    tree.addTile(2, Coord(256, 256, 384), 2.5f, false);
    tree.addTile(1, Coord(0, 8, 16), 3.0f, true);         // 8^3
    tree.addTile(1, Coord(8, 8, 16), -1.5f, false);
    for (int i = 0; i < 300; i++) { // two leaves' worth of voxels on a crooked line, some at negative coordinates
        Coord at(i % 7 - 3, (i * 3) % 11 - 5, (i * 5) % 13 - 20);
        tree.setValue(at, 0.01f * float(i + 1));
    }
    tree.setValueOff(Coord(-1, -1, -20), 9.0f); // inactive voxels keep what they hold
}

static void report(const char* name, const openvdb::FloatGrid& grid) {
    double sum = 0;
    float lo = 1e30f, hi = -1e30f;
    for (auto it = grid.cbeginValueOn(); it; ++it) {
        sum += double(*it) * double(it.getVoxelCount());
        lo = std::min(lo, *it);
        hi = std::max(hi, *it);
    }
    auto box = grid.evalActiveVoxelBoundingBox();
    std::printf("%s background %.9g voxels %llu leaves %u min %.9g max %.9g sum %.17g box", name, grid.background(),
                (unsigned long long)grid.activeVoxelCount(), unsigned(grid.tree().leafCount()), lo, hi, sum);
    for (int i = 0; i < 3; i++) std::printf(" %d %d", box.min()[i], box.max()[i]);
    std::printf("\n");
    for (auto p : {Coord(0, 0, 0), Coord(1, 0, 0), Coord(0, 1, 0), Coord(0, 0, 1), Coord(-3, 5, -7)}) {
        auto w = grid.indexToWorld(p);
        std::printf("world %d %d %d -> %.17g %.17g %.17g\n", p[0], p[1], p[2], w[0], w[1], w[2]);
    }
    const Coord probes[] = {{-4096, 0, 0}, {-1, 4095, 4095}, {-4097, 0, 0}, {100, -4097, 8191}, {100, -4096, 8191},
        {128, 256, 384}, {255, 383, 511}, {256, 256, 384}, {383, 383, 511}, {384, 256, 384}, {0, 8, 16}, {7, 15, 23},
        {8, 8, 16}, {15, 15, 23}, {16, 8, 16}, {-3, -5, -20}, {-2, -2, -15}, {-1, 1, -10}, {2, 3, -9}, {-1, -1, -20},
        {3, 5, -8}, {-8, -8, -24}, {2000000000, 0, 0}, {-2147483647 - 1, 2147483647, -2147483647 - 1}};
    for (const auto& p : probes) {
        float value;
        bool on = grid.tree().probeValue(p, value);
        std::printf("probe %d %d %d %.9g %d\n", p[0], p[1], p[2], value, on);
    }
}

int main() {
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(0.125f);
    grid->setName("tiles");
    fill(*grid);
    openvdb::math::Mat4d m(0.5, 0.25, 0.0, 0.0, -0.5, 1.0, 0.125, 0.0, 0.0, 0.0625, 2.0, 0.0, 10.0, -20.0, 30.5, 1.0);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    report("tiles", *grid);

    std::vector<nanovdb::GridHandle<nanovdb::HostBuffer>> handles;
    auto keep = [&](auto handle) { handles.push_back(std::move(handle)); };
    keep(nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, float>(*grid, nanovdb::StatsMode::All, nanovdb::ChecksumMode::Full));
    auto quantised = [&](const char* name, auto type) {
        grid->setName(name);
        keep(nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, decltype(type)>(*grid, nanovdb::StatsMode::All, nanovdb::ChecksumMode::Full));
    };
    quantised("tiles_fp4", nanovdb::Fp4());
    quantised("tiles_fp8", nanovdb::Fp8());
    quantised("tiles_fp16", nanovdb::Fp16());
    quantised("tiles_fpn", nanovdb::FpN());
    auto empty = openvdb::FloatGrid::create(-2.0f);
    empty->setName("empty");
    empty->setGridClass(openvdb::GRID_LEVEL_SET);
    keep(nanovdb::openToNanoVDB(empty));
    auto whole = openvdb::DoubleGrid::create(0.0);
    whole->setName("double");
    whole->tree().setValue(Coord(1, 2, 3), 4.0);
    keep(nanovdb::openToNanoVDB(whole));
    auto mask = openvdb::MaskGrid::create();
    mask->setName("mask");
    mask->tree().setValueOn(Coord(1, 2, 3));
    keep(nanovdb::openToNanoVDB(mask));
    nanovdb::io::writeGrids("tiles.zip.nvdb", handles, nanovdb::io::Codec::ZIP);
    return 0;
}
