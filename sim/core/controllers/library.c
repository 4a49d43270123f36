// Finds the act of a controller of the library by its name.

#include "library.h"

#include <stddef.h>
#include <string.h>

typedef struct Named {
    const char *name;
    WgAct act;
} Named;

#define WG_ENTRY(name, act) {name, act},
static const Named LIBRARY[] = {WG_LIBRARY(WG_ENTRY)};
#undef WG_ENTRY

WgAct wg_library_act(const char *name)
{
    for (size_t k = 0; k < sizeof LIBRARY / sizeof LIBRARY[0]; k++) {
        if (strcmp(LIBRARY[k].name, name) == 0) {
            return LIBRARY[k].act;
        }
    }
    return NULL;
}
