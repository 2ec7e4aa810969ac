/* SPDX-License-Identifier: Apache-2.0
 *
 * For scripts/vectors: lines `FUNCTION WORDS...` (a number of functions.h, hexadecimal words) on standard input become lines
 * of NPH_WORDS_OUT words. Compiled against the library's headers, or with PORTABLE defined against nephos/portable.h; as C++
 * too. */
#include <stdio.h>

#ifdef PORTABLE
#include "nephos/portable.h"
#else
#include "core_names.h"
#endif
#include "evaluate.h"

int main(void) {
    int function;
    while (scanf("%d", &function) == 1) {
        uint32_t in[NPH_WORDS_IN] = {0}, out[NPH_WORDS_OUT] = {0};
        unsigned word;
        for (int i = 0; i < NPH_WORDS_IN && scanf("%x", &word) == 1; i++) in[i] = word;
        nph_evaluate(function, in, out);
        for (int i = 0; i < NPH_WORDS_OUT; i++) printf("%08x%c", (unsigned)out[i], i + 1 < NPH_WORDS_OUT ? ' ' : '\n');
    }
    return 0;
}
