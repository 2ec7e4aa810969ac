/* SPDX-License-Identifier: Apache-2.0
 *
 * See bugs.h. */
#include "bugs/bugs.h"

#include <stdlib.h>

#include "core/bug.h"

void bugs_choose(void) {
    const char *number = getenv("NEPHOS_BUG");
    nph_bug_number = number ? atoi(number) : 0;
}
