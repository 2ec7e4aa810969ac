// SPDX-License-Identifier: Apache-2.0
// An environment map of 1024 x 512 pixels as one of 128 x 64: means of 8 x 8 pixels, below 0 is 0, half, ZIP.
// g++ make_indoors.cc $(pkg-config --cflags --libs OpenEXR) -o make_indoors; ./make_indoors courtyard.exr courtyard128.exr
#include <ImfRgbaFile.h>
#include <algorithm>
#include <vector>

int main(int, char **argument) {
    Imf::RgbaInputFile in(argument[1]);
    const int width = 1024, part = 8, out_width = width / part, out_height = width / 2 / part;
    std::vector<Imf::Rgba> from(width * width / 2), to(out_width * out_height);
    in.setFrameBuffer(from.data(), 1, width);
    in.readPixels(0, width / 2 - 1);
    for (int y = 0; y < out_height; y++)
        for (int x = 0; x < out_width; x++) {
            double sum[3] = {0, 0, 0};
            for (int k = 0; k < part * part; k++) {
                const Imf::Rgba &p = from[(y * part + k / part) * width + x * part + k % part];
                sum[0] += std::max(0.0f, float(p.r));
                sum[1] += std::max(0.0f, float(p.g));
                sum[2] += std::max(0.0f, float(p.b));
            }
            to[y * out_width + x] = Imf::Rgba(float(sum[0] / 64), float(sum[1] / 64), float(sum[2] / 64), 1.0f);
        }
    Imf::RgbaOutputFile out(argument[2], out_width, out_height, Imf::WRITE_RGB);
    out.setFrameBuffer(to.data(), 1, out_width);
    out.writePixels(out_height);
}
