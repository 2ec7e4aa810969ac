/* SPDX-License-Identifier: Apache-2.0
 *
 * In test programs that are built against altered kernels (altered/altered.h): the bug to make is the number in
 * NEPHOS_BUG, none when there is no such variable. */
#ifndef NPH_TESTS_BUGS_H
#define NPH_TESTS_BUGS_H

void bugs_choose(void);

#endif
