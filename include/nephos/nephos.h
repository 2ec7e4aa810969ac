/* SPDX-License-Identifier: Apache-2.0
 *
 * All public headers. A first program: open a context, load a scene, render it to a film, make an image of the film, write
 * the image (examples/render.c). */
#ifndef NEPHOS_NEPHOS_H
#define NEPHOS_NEPHOS_H

#include "nephos/conventions.h"
#include "nephos/status.h"
#include "nephos/context.h"
#include "nephos/array.h"
#include "nephos/image.h"
#include "nephos/scene.h"
#include "nephos/film.h"
#include "nephos/render.h"
#include "nephos/compare.h"
#include "nephos/flip.h"
#include "nephos/stage.h"
#include "nephos/verify.h"
#include "nephos/watch.h"

#endif
