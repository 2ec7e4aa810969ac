/* SPDX-License-Identifier: Apache-2.0 */
/* A plain scalar path tracer for the three scenes of peers.md: the floor that nephos must clear, run beside it on the same
 * machine. Delta tracking through a majorant grid, ratio-tracked sun, no vectors, no threads, float. Not a model of style.
 *   cc -O3 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math yardstick.c -o yardstick -lm
 *   ./yardstick cube 0.7 [spp] [alpha]      alpha < 1 mixes a lobe towards the sun into the phase sampling
 *   ./yardstick smoke smoke128_zyx.npy [spp]
 *   ./yardstick rico rico122x106x39.txt [spp] [alpha]
 * Prints samples per CPU second, standard deviation of one sample over the lit mean, and efficiency 1/(relRMSE^2 x CPU s). */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct { int n[3], m[3]; float lo[3], hi[3], *d, *maj; float g, albedo, sky, sun, dir[3], alpha, gs; } Scene;
static uint64_t state = 88172645463325252ull;
static float rnd(void) { state = state * 6364136223846793005ull + 1442695040888963407ull; return (float)(state >> 40) * (1.f / 16777216.f); }
static double cpu(void) { struct timespec t; clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec; }
static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static float hg(float c, float g) { float q = 1 + g * g - 2 * g * c; return (1 - g * g) / (12.5663706f * q * sqrtf(q)); }
static float hg_cos(float g, float u) { if (fabsf(g) < 1e-3f) return 1 - 2 * u; float w = (1 - g * g) / (1 - g + 2 * g * u); return (1 + g * g - w * w) / (2 * g); }
static void turn(const float d[3], float c, float o[3]) {
    float s = sqrtf(fmaxf(0, 1 - c * c)), f = 6.2831853f * rnd(), cf = cosf(f), sf = sinf(f);
    float sg = copysignf(1, d[2]), a = -1 / (sg + d[2]), b = d[0] * d[1] * a;
    float X[3] = {1 + sg * d[0] * d[0] * a, sg * b, -sg * d[0]}, Y[3] = {b, sg + d[1] * d[1] * a, -d[1]};
    for (int k = 0; k < 3; k++) o[k] = s * (cf * X[k] + sf * Y[k]) + c * d[k];
}
static float at(const Scene *s, const float p[3]) { /* trilinear, cell-centred, zero outside */
    if (!s->d) return 4;
    float q[3], w[3]; int i[3]; const int *n = s->n;
    for (int k = 0; k < 3; k++) { q[k] = (p[k] - s->lo[k]) / (s->hi[k] - s->lo[k]) * (float)n[k] + .5f; i[k] = (int)q[k]; w[k] = q[k] - (float)i[k]; if (q[k] < 0 || i[k] > n[k]) return 0; }
    size_t X = (size_t)n[0] + 2, Y = (size_t)n[1] + 2; const float *v = s->d + ((size_t)i[2] * Y + (size_t)i[1]) * X + (size_t)i[0];
    float a = v[0] + w[0] * (v[1] - v[0]), b = v[X] + w[0] * (v[X + 1] - v[X]); v += X * Y;
    float c = v[0] + w[0] * (v[1] - v[0]), e = v[X] + w[0] * (v[X + 1] - v[X]);
    a += w[1] * (b - a); c += w[1] * (e - c); return a + w[2] * (c - a);
}
/* Walks from p along d. Delta tracking: returns the collision distance or -1. With ratio != 0: returns the transmittance. */
static float walk(const Scene *s, const float p[3], const float d[3], float t, int ratio, float *T) {
    int c[3], st[3]; float tm[3], td[3], tau = -logf(1 - rnd()); *T = 1;
    for (int k = 0; k < 3; k++) {
        float h = (s->hi[k] - s->lo[k]) / (float)s->m[k], o = (p[k] + t * d[k] - s->lo[k]) / h;
        c[k] = (int)o; if (c[k] < 0) c[k] = 0; if (c[k] > s->m[k] - 1) c[k] = s->m[k] - 1;
        float inv = 1 / d[k]; st[k] = d[k] > 0 ? 1 : -1; td[k] = fabsf(inv) * h; tm[k] = t + ((float)(c[k] + (d[k] > 0)) - o) * h * inv;
    }
    for (;;) {
        int a = tm[0] < tm[1] ? (tm[0] < tm[2] ? 0 : 2) : (tm[1] < tm[2] ? 1 : 2);
        float m = s->maj[(c[2] * s->m[1] + c[1]) * s->m[0] + c[0]], dt = tm[a] - t;
        if (m * dt > tau) {
            t += tau / m; float q[3] = {p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]}, e = at(s, q);
            if (ratio) { *T *= 1 - e / m; if (*T < .05f) { if (rnd() < .75f) { *T = 0; return -1; } *T *= 4; } }
            else if (rnd() * m < e) return t;
            tau = -logf(1 - rnd()); continue;
        }
        tau -= m * dt; t = tm[a]; tm[a] += td[a]; c[a] += st[a];
        if (c[a] < 0 || c[a] >= s->m[a]) return -1;
    }
}
static float path(const Scene *s, float p[3], float d[3]) {
    float t0 = 0, t1 = 1e30f, w = 1, L = 0, T;
    for (int k = 0; k < 3; k++) { float i = 1 / d[k], a = (s->lo[k] - p[k]) * i, b = (s->hi[k] - p[k]) * i; if (a > b) { float z = a; a = b; b = z; } if (a > t0) t0 = a; if (b < t1) t1 = b; }
    if (t0 >= t1) return s->sky;
    for (;;) {
        float t = walk(s, p, d, t0, 0, &T); if (t < 0) return L + w * s->sky;
        t0 = 0; w *= s->albedo; for (int k = 0; k < 3; k++) p[k] += t * d[k];
        if (s->sun > 0) { walk(s, p, s->dir, 0, 1, &T); L += w * s->sun * T * hg(dot(d, s->dir), s->g); }
        float n[3];
        if (s->alpha >= 1 || rnd() < s->alpha) turn(d, hg_cos(s->g, rnd()), n); else turn(s->dir, hg_cos(s->gs, rnd()), n);
        if (s->alpha < 1) { float a = hg(dot(d, n), s->g), b = hg(dot(s->dir, n), s->gs); w *= a / (s->alpha * a + (1 - s->alpha) * b); }
        memcpy(d, n, sizeof n);
        if (w < .1f) { if (rnd() > w * 5) return L; w = .2f; }
    }
}
static void grid(Scene *s, int cell) { /* majorants of cell^3 cells, exact under trilinear lookup */
    for (int k = 0; k < 3; k++) s->m[k] = (s->n[k] + cell - 1) / cell;
    s->maj = calloc((size_t)(s->m[0] * s->m[1] * s->m[2]), sizeof(float)); size_t X = (size_t)s->n[0] + 2, Y = (size_t)s->n[1] + 2;
    for (int z = 0; z < s->m[2]; z++) for (int y = 0; y < s->m[1]; y++) for (int x = 0; x < s->m[0]; x++) {
        int a[3] = {x, y, z}, lo[3], hi[3]; float m = 0;
        for (int k = 0; k < 3; k++) { lo[k] = (int)floorf((float)a[k] * (float)s->n[k] / (float)s->m[k]); hi[k] = (int)ceilf((float)(a[k] + 1) * (float)s->n[k] / (float)s->m[k]) + 1; if (hi[k] > s->n[k] + 1) hi[k] = s->n[k] + 1; }
        for (int k = lo[2]; k <= hi[2]; k++) for (int j = lo[1]; j <= hi[1]; j++) for (int i = lo[0]; i <= hi[0]; i++) { float v = s->d[((size_t)k * Y + (size_t)j) * X + (size_t)i]; if (v > m) m = v; }
        s->maj[(z * s->m[1] + y) * s->m[0] + x] = m;
    }
}
int main(int argc, char **argv) {
    if (argc < 3) return 2;
    Scene s = {.n = {1, 1, 1}, .m = {1, 1, 1}, .hi = {1, 1, 1}, .g = .7f, .albedo = 1, .alpha = 1, .gs = .9f}; static float four = 4;
    float eye[3] = {-1.5f, -1.5f, .5f}, to[3] = {.5f, .5f, .5f}, fov = 35; int W = 256, H = 256, spp = argc > 3 ? atoi(argv[3]) : 16; float lit_at = 0;
    if (argc > 4) s.alpha = (float)atof(argv[4]);
    if (!strcmp(argv[1], "cube")) { s.g = (float)atof(argv[2]); s.maj = &four; s.sun = 3.14159265f; s.dir[0] = -1; s.dir[1] = 1e-7f; s.dir[2] = 1e-7f; }
    else if (!strcmp(argv[1], "smoke")) {
        s.g = .42f; s.albedo = .7f; s.sky = 1; s.n[0] = s.n[1] = s.n[2] = 128; s.d = calloc(130u * 130 * 130, 4); FILE *f = fopen(argv[2], "rb"); if (!f) return 2;
        fseek(f, -128L * 128 * 128 * 4, SEEK_END); for (int k = 1; k <= 128; k++) for (int j = 1; j <= 128; j++) if (fread(s.d + ((size_t)k * 130 + (size_t)j) * 130 + 1, 4, 128, f) != 128) return 2;
        fclose(f); grid(&s, 4); float e[3] = {.5f, -1.9f, .6f}; memcpy(eye, e, sizeof e); fov = 16; W = 400; H = 300; lit_at = .05f;
    } else {
        FILE *f = fopen(argv[2], "r"); if (!f) return 2; char line[4096]; if (!fgets(line, 4096, f) || !fgets(line, 4096, f) || sscanf(line, "%d,%d,%d", s.n, s.n + 1, s.n + 2) != 3) return 2;
        for (int k = 0; k < 3; k++) if (!fgets(line, 4096, f)) return 2;
        size_t X = (size_t)s.n[0] + 2, Y = (size_t)s.n[1] + 2; s.d = calloc(X * Y * ((size_t)s.n[2] + 2), 4); int i, j, k; float lwc, re;
        while (fgets(line, 4096, f)) if (sscanf(line, "%d,%d,%d,%f,%f", &i, &j, &k, &lwc, &re) == 5 && re > 0) s.d[((size_t)(k + 1) * Y + (size_t)j + 1) * X + (size_t)i + 1] = 1.5f * lwc / re;
        fclose(f); float lo[3] = {0, 0, 420}, hi[3] = {2440, 2120, 1980}, e[3] = {1780, -2400, 800}, t[3] = {1780, 1050, 1060}; memcpy(s.lo, lo, 12); memcpy(s.hi, hi, 12); memcpy(eye, e, 12); memcpy(to, t, 12);
        grid(&s, 4); s.g = .85f; s.sky = .19f; s.sun = 3.14159265f; s.dir[0] = -.5f; s.dir[1] = -.5f; s.dir[2] = .70710678f; fov = 20; W = 400; H = 300; lit_at = .05f;
    }
    float f[3], r[3], u[3], q; for (int k = 0; k < 3; k++) f[k] = to[k] - eye[k]; q = 1 / sqrtf(dot(f, f)); for (int k = 0; k < 3; k++) f[k] *= q;
    r[0] = f[1]; r[1] = -f[0]; r[2] = 0; q = 1 / sqrtf(dot(r, r)); for (int k = 0; k < 3; k++) r[k] *= q;
    u[0] = r[1] * f[2] - r[2] * f[1]; u[1] = r[2] * f[0] - r[0] * f[2]; u[2] = r[0] * f[1] - r[1] * f[0];
    float th = tanf(fov * 3.14159265f / 360) / (float)(H < W ? H : W); double sum = 0, var = 0, t = cpu(); long lit = 0;
    for (int y = 0; y < H; y++) for (int x = 0; x < W; x++) {
        double a = 0, b = 0;
        for (int i = 0; i < spp; i++) {
            float px = (2 * ((float)x + rnd()) - (float)W) * th, py = ((float)H - 2 * ((float)y + rnd())) * th, d[3], p[3]; memcpy(p, eye, sizeof p);
            for (int k = 0; k < 3; k++) d[k] = f[k] + px * r[k] + py * u[k];
            q = 1 / sqrtf(dot(d, d));
            for (int k = 0; k < 3; k++) d[k] *= q;
            double L = path(&s, p, d); a += L; b += L * L;
        }
        a /= spp; b = b / spp - a * a; if (b > 0 && fabs(a - s.sky) > lit_at * s.sky) { lit++; sum += a; var += b * spp / (spp > 1 ? spp - 1 : 1); }
    }
    t = cpu() - t; double mean = sum / (double)lit, rel = sqrt(var / (double)lit) / mean;
    printf("%s %s: %.3f Msamples/CPU-s, lit %.1f%%, lit mean %.5f, std/mean %.3f, efficiency %.4f\n", argv[1], argv[2], (double)W * H * spp / t / 1e6, 100. * (double)lit / W / H, mean, rel, spp / (rel * rel) / t);
    return 0;
}
