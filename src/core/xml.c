/* SPDX-License-Identifier: Apache-2.0
 *
 * See xml.h. */
#include "core/xml.h"

#include <string.h>

/* Bytes of the UTF-8 sequence that begins here, 0 when it is none, or one that XML does not allow. */
static int sequence_length(const unsigned char *text) {
    static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
    int length = text[0] < 0x80 ? 1 : text[0] >> 5 == 6 ? 2 : text[0] >> 4 == 14 ? 3 : text[0] >> 3 == 30 ? 4 : 0;
    uint32_t letter = length == 1 ? text[0] : text[0] & (0x7fu >> length);
    for (int i = 1; i < length; i++) {
        if (text[i] >> 6 != 2) return 0;
        letter = letter << 6 | (text[i] & 0x3fu);
    }
    if (length == 0 || letter < least[length] || letter > 0x10ffff) return 0;
    int forbidden = (letter >= 0xd800 && letter < 0xe000) || letter == 0xfffe || letter == 0xffff;
    int control = letter < 0x20 && letter != '\t' && letter != '\n' && letter != '\r';
    return forbidden || control ? 0 : length;
}

/* Breaks and tabs as references too: inside an attribute a reader would make blanks of them. */
static const char *reference_of(char letter) {
    switch (letter) {
    case '&': return "&amp;";
    case '<': return "&lt;";
    case '>': return "&gt;";
    case '"': return "&quot;";
    case '\t': return "&#9;";
    case '\n': return "&#10;";
    case '\r': return "&#13;";
    default: return NULL;
    }
}

void nph_xml_text(NphTextFn write, void *user, const char *text) {
    while (*text) {
        int length = sequence_length((const unsigned char *)text);
        const char *reference = reference_of(*text);
        if (reference) write(user, reference, strlen(reference));
        else if (length > 0) write(user, text, (size_t)length);
        else write(user, "\xef\xbf\xbd", 3);
        text += length > 0 ? length : 1;
    }
}
