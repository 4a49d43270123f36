// Finds shortest closed chains of cells that wind around a pose: breadth-first over (cell, bits).
//
// A cell that has been seen is removed from its row, so that the search never examines a cell
// twice: of the thousands of links that a wide disc gives each cell, it follows only those to new
// cells.

#include <stdlib.h>
#include <string.h>

#include "links.h"

enum {
    MOST_TARGETS = 6,
    STARTS = 24,      // cells from which a short cycle is searched for
    WORK = 20000000,  // limit on the cells and rows that those searches examine
};

// A walk over (cell, bits) from (source, no bit) to (source, all bits).
typedef struct Walk {
    int32_t *before;  // (cells << bits,) the state before a state, -1 if it was not seen
    int32_t *order;   // (cells << bits,) states in the order in which they are seen
    int32_t *skip;    // ((cells + 1) << bits,) link to the next unseen cell of the layer
    int64_t source;
    int64_t head;
    int64_t tail;
    int64_t level_end;
    int64_t depth;
    int64_t looked;  // rows and cells examined
    bool under_way;
} Walk;

// The stages of a search.
typedef enum Phase {
    MARKING,  // which cells near a ray have odd cycles
    WALKING,  // shortest cycles from some of them
    FINISHED,
} Phase;

struct WgCutSearch {
    WgLinks links;
    WgFinePose poses[MOST_TARGETS + 1];
    uint32_t *digits;  // digits of the poses
    int64_t *near;  // (poses, 2) their whole 1/1024 cells
    Walk walk;
    Phase phase;
    // (slots,) cells with links that have bits, by number at first, later in search order
    int32_t *sources;
    int64_t source_count;
    int64_t at;  // the source in progress
    int64_t work;
    int32_t *chain;  // (cells << bits,) the best one, the last cell first
    int64_t length;
};

static inline void see(const WgLinks *links, Walk *walk, int64_t cell, int64_t layer, int64_t from)
{
    int64_t state = (cell << links->bits) + layer;
    int64_t place = layer * (links->cells + 1) + cell;
    walk->before[state] = (int32_t)from;
    walk->skip[place] = (int32_t)(place + 1);
    walk->order[walk->tail++] = (int32_t)state;
}

// Follows the listed links of a cell near a ray; only these have bits.
static void follow_listed(const WgLinks *links, Walk *walk, int64_t state, int64_t slot, int64_t layer)
{
    for (int64_t link = links->begins[slot]; link < links->begins[slot + 1]; link++) {
        int64_t other_layer = layer ^ (int64_t)links->odd[link];
        int64_t cell = links->ends[link];
        walk->looked++;
        if (walk->before[(cell << links->bits) + other_layer] < 0) {
            see(links, walk, cell, other_layer, state);
        }
    }
}

// Follows all other cells' links, row by row, to cells that were not seen in this layer.
static void follow_rows(const WgLinks *links, Walk *walk, int64_t state, int64_t cell, int64_t layer)
{
    int64_t base = layer * (links->cells + 1);
    for (int64_t row = 0; row <= 2 * links->reach; row++) {
        int64_t at = links->place[cell] + links->shift[row];
        int64_t last = base + links->rank[at + links->wide[row] + 1];
        int64_t v = base + links->rank[at - links->wide[row]];
        walk->looked++;
        while (v < last) {
            v = wg_next_unseen(walk->skip, v);
            if (v >= last) {
                break;
            }
            see(links, walk, v - base, layer, state);
            walk->looked++;
        }
    }
}

// Clears the marks of visited nodes.
static void begin_again(const WgLinks *links, Walk *walk)
{
    int64_t states = links->cells << links->bits;
    int64_t entries = (links->cells + 1) << links->bits;
    memset(walk->before, 0xff, (size_t)states * sizeof *walk->before);
    for (int64_t i = 0; i < entries; i++) {
        walk->skip[i] = (int32_t)i;
    }
}

static void begin_walk(const WgLinks *links, Walk *walk, int64_t source)
{
    walk->source = source;
    walk->head = 0;
    walk->tail = 0;
    walk->level_end = 1;
    walk->depth = 0;
    walk->looked = 0;
    walk->under_way = true;
    see(links, walk, source, 0, source << links->bits);
}

// Continues for about ``most`` cells; returns true if the walk has ended.
//
// limit:      upper bound on the chain's links, exclusive.
// thorough:   if true, continue until everything reachable is seen.
static bool go_on(const WgLinks *links, Walk *walk, int64_t limit, bool thorough, int64_t most)
{
    int64_t full = ((int64_t)1 << links->bits) - 1;
    int64_t goal = (walk->source << links->bits) + full;
    int64_t enough = walk->looked + most;
    while (walk->head < walk->tail && (thorough || walk->before[goal] < 0)) {
        if (walk->looked >= enough) {
            return false;
        }
        if (walk->head == walk->level_end) {
            walk->depth++;
            walk->level_end = walk->tail;
            if (walk->depth + 1 >= limit) {
                break;
            }
        }
        int64_t state = walk->order[walk->head++];
        int64_t cell = state >> links->bits;
        if (links->slot[cell] >= 0) {
            follow_listed(links, walk, state, links->slot[cell], state & full);
        } else {
            follow_rows(links, walk, state, cell, state & full);
        }
    }
    walk->under_way = false;
    return true;
}

// Keeps the chain if one was found, the last cell first, and clears the marks.
static void take_chain(WgCutSearch *search)
{
    const WgLinks *links = &search->links;
    Walk *walk = &search->walk;
    int64_t full = ((int64_t)1 << links->bits) - 1;
    int64_t state = (walk->source << links->bits) + full;
    if (walk->before[state] >= 0) {
        search->length = 0;
        while (state != walk->source << links->bits) {
            search->chain[search->length++] = (int32_t)(state >> links->bits);
            state = walk->before[state];
        }
    }
    for (int64_t i = 0; i < walk->tail; i++) {
        state = walk->order[i];
        int64_t place = (state & full) * (links->cells + 1) + (state >> links->bits);
        walk->before[state] = -1;
        walk->skip[place] = (int32_t)place;
    }
}

// Squared distance, lu, from a cell's middle to the nearest pose.
static int64_t apart_sq(const WgCutSearch *search, int64_t cell)
{
    int64_t least = INT64_MAX;
    for (int64_t k = 0; k <= search->links.bits; k++) {
        int64_t dx = WG_UNIT * (int64_t)search->links.column[cell] + WG_UNIT / 2 - search->near[2 * k];
        int64_t dy = WG_UNIT * (int64_t)search->links.row[cell] + WG_UNIT / 2 - search->near[2 * k + 1];
        least = wg_min(least, dx * dx + dy * dy);
    }
    return least;
}

typedef struct Ranked {
    int64_t apart_sq;
    int32_t cell;
} Ranked;

static int by_distance(const void *a, const void *b)
{
    const Ranked *one = a;
    const Ranked *two = b;
    if (one->apart_sq != two->apart_sq) {
        return one->apart_sq < two->apart_sq ? -1 : 1;
    }
    return one->cell < two->cell ? -1 : one->cell > two->cell;
}

// Chooses a few sources, near and far; with several targets, appends all the others after them.
static bool choose_sources(WgCutSearch *search)
{
    int64_t count = search->source_count;
    Ranked *ranked = malloc((size_t)(count + 1) * sizeof *ranked);
    uint8_t *is_chosen = calloc((size_t)(count + 1), 1);
    if (ranked == NULL || is_chosen == NULL) {
        free(ranked);
        free(is_chosen);
        return false;
    }
    for (int64_t i = 0; i < count; i++) {
        ranked[i] = (Ranked){apart_sq(search, search->sources[i]), search->sources[i]};
    }
    qsort(ranked, (size_t)count, sizeof *ranked, by_distance);
    double step = (double)(count - 1) / (STARTS - 1);
    int64_t kept = 0;
    for (int64_t i = 0; i < STARTS && count > 0; i++) {
        int64_t index = i == STARTS - 1 ? count - 1 : (int64_t)((double)i * step);
        if (is_chosen[index] == 0) {
            is_chosen[index] = 1;
            search->sources[kept++] = ranked[index].cell;
        }
    }
    for (int64_t i = 0; i < count && search->links.bits > 1; i++) {
        if (is_chosen[i] == 0) {
            search->sources[kept++] = ranked[i].cell;
        }
    }
    search->source_count = kept;
    search->at = 0;
    free(ranked);
    free(is_chosen);
    return true;
}

// The bit of the link between two cells by number.
static bool is_odd(const WgCutSearch *search, int32_t a, int32_t b)
{
    const WgLinks *links = &search->links;
    return wg_link_bits(search->poses, links->bits + 1, links->column[a], links->row[a], links->column[b],
                        links->row[b]) != 0;
}

// Splits the chain at cells that it visits twice, and keeps an odd part each time.
static WgStatus simplify(WgCutSearch *search)
{
    int64_t count = search->length;
    int32_t *where = search->walk.before;  // position of a cell in the kept part, or -1
    int32_t *kept = search->walk.order;
    // parities of the steps from each kept cell to the next
    uint8_t *odd = malloc((size_t)(count + 1));
    if (odd == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t held = 0;
    for (int64_t i = 0; i < count; i++) {
        int32_t cell = search->chain[i];
        int64_t from = where[cell];
        if (from >= 0) {
            bool sum = false;
            for (int64_t j = from; j < held; j++) {
                sum = sum != (odd[j] != 0);
            }
            if (sum) {
                memmove(kept, kept + from, (size_t)(held - from) * sizeof *kept);
                held -= from;
                break;
            }
            for (int64_t j = from; j < held; j++) {
                where[kept[j]] = -1;
            }
            held = from;
        }
        where[cell] = (int32_t)held;
        kept[held] = cell;
        odd[held++] = is_odd(search, cell, search->chain[i + 1 == count ? 0 : i + 1]);
    }
    memcpy(search->chain, kept, (size_t)held * sizeof *kept);
    search->length = held;
    free(odd);
    return WG_OK;
}

static WgStatus allocate(WgCutSearch *search)
{
    const WgLinks *links = &search->links;
    int64_t entries = (links->cells + 1) << links->bits;
    if (entries > INT32_MAX) {
        return WG_BAD_VALUE;
    }
    size_t room = (size_t)entries * sizeof(int32_t);
    search->walk.before = malloc(room);
    search->walk.order = malloc(room);
    search->walk.skip = malloc(room);
    search->chain = malloc(room);
    search->sources = malloc((size_t)(links->slots + 1) * sizeof *search->sources);
    if (search->walk.before == NULL || search->walk.order == NULL || search->walk.skip == NULL ||
        search->chain == NULL || search->sources == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t cell = 0; cell < links->cells; cell++) {
        if (links->slot[cell] >= 0) {
            search->sources[search->source_count++] = (int32_t)cell;
        }
    }
    begin_again(links, &search->walk);
    return WG_OK;
}

static WgStatus begin_search(WgCutSearch *search, const WgWalls *walls, int64_t limit, int64_t targets,
                             const int64_t *poses, int64_t limbs, const uint32_t *rest)
{
    search->near = malloc((size_t)(2 * (targets + 1)) * sizeof *search->near);
    search->digits = malloc((size_t)(2 * (targets + 1) * limbs) * sizeof *search->digits);
    if (search->near == NULL || search->digits == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    memcpy(search->digits, rest, (size_t)(2 * (targets + 1) * limbs) * sizeof *search->digits);
    for (int64_t k = 0; k <= targets; k++) {
        const uint32_t *digits = search->digits + 2 * k * limbs;
        search->poses[k] = (WgFinePose){poses[2 * k], poses[2 * k + 1], digits, digits + limbs, limbs};
        search->near[2 * k] = poses[2 * k] * (WG_UNIT / 2) + (digits[0] >> 23);
        search->near[2 * k + 1] = poses[2 * k + 1] * (WG_UNIT / 2) + (digits[limbs] >> 23);
    }
    WgStatus status = wg_links_make(&search->links, walls, limit, search->poses, targets + 1);
    return status == WG_OK ? allocate(search) : status;
}

WgStatus wg_cut_search_new(const WgWalls *walls, int64_t limit, int64_t targets, const int64_t *poses, int64_t limbs,
                           const uint32_t *rest, WgCutSearch **made)
{
    *made = NULL;
    if (targets < 1 || targets > MOST_TARGETS || limbs < 1 || limbs > 4096) {
        return WG_BAD_VALUE;
    }
    for (int64_t i = 0; i < 2 * (targets + 1); i++) {
        if (poses[i] < -1 || poses[i] > 40001) {
            return WG_BAD_VALUE;
        }
    }
    WgCutSearch *search = calloc(1, sizeof *search);
    if (search == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    search->work = targets > 1 ? 10 * (int64_t)WORK : WORK;
    WgStatus status = begin_search(search, walls, limit, targets, poses, limbs, rest);
    // With several poses, each cell near a ray may be in a cycle around all of them.
    search->phase = targets > 1 ? WALKING : MARKING;
    if (status == WG_OK && targets > 1 && !choose_sources(search)) {
        status = WG_OUT_OF_MEMORY;
    }
    if (status != WG_OK) {
        wg_cut_search_free(search);
        return status;
    }
    *made = search;
    return WG_OK;
}

// Follows all links from each unseen source, then keeps the sources that were seen with both bits.
static WgStatus mark(WgCutSearch *search, int64_t *most)
{
    Walk *walk = &search->walk;
    for (; search->at < search->source_count; search->at++) {
        int64_t source = search->sources[search->at];
        if (!walk->under_way) {
            if (walk->before[2 * source] >= 0 || walk->before[2 * source + 1] >= 0) {
                continue;
            }
            begin_walk(&search->links, walk, source);
        }
        int64_t before = walk->looked;
        bool ended = go_on(&search->links, walk, 2 * search->links.cells, true, *most);
        *most -= walk->looked - before;
        if (!ended) {
            return WG_OK;
        }
    }
    int64_t kept = 0;
    for (int64_t i = 0; i < search->source_count; i++) {
        int64_t source = search->sources[i];
        if (walk->before[2 * source] >= 0 && walk->before[2 * source + 1] >= 0) {
            search->sources[kept++] = (int32_t)source;
        }
    }
    search->source_count = kept;
    begin_again(&search->links, walk);
    if (!choose_sources(search)) {
        return WG_OUT_OF_MEMORY;
    }
    search->phase = WALKING;
    return WG_OK;
}

WgStatus wg_cut_search_advance(WgCutSearch *search, int64_t most, WgProgress *progress)
{
    *progress = WG_GOING;
    if (search->phase == MARKING) {
        WgStatus status = mark(search, &most);
        if (status != WG_OK || search->phase == MARKING) {
            return status;
        }
    }
    Walk *walk = &search->walk;
    int64_t bits = search->links.bits;
    while (search->phase == WALKING) {
        if (search->at == search->source_count || (search->work < 0 && (search->length > 0 || bits > 1))) {
            search->phase = FINISHED;
            WgStatus status = bits == 1 && search->length > 0 ? simplify(search) : WG_OK;
            if (status != WG_OK) {
                return status;
            }
            break;
        }
        if (!walk->under_way) {
            begin_walk(&search->links, walk, search->sources[search->at]);
        }
        int64_t limit = search->length > 0 ? search->length : search->links.cells << bits;
        int64_t before = walk->looked;
        bool ended = go_on(&search->links, walk, limit, false, most);
        most -= walk->looked - before;
        if (!ended) {
            return WG_OK;
        }
        take_chain(search);
        search->work -= walk->looked;
        search->at++;
    }
    *progress = search->length > 0 ? WG_FOUND : WG_EXHAUSTED;
    return WG_OK;
}

int64_t wg_cut_length(const WgCutSearch *search)
{
    return search->length;
}

void wg_cut_cells(const WgCutSearch *search, int64_t *cells)
{
    for (int64_t i = 0; i < search->length; i++) {
        cells[2 * i] = search->links.column[search->chain[i]];
        cells[2 * i + 1] = search->links.row[search->chain[i]];
    }
}

void wg_cut_search_free(WgCutSearch *search)
{
    if (search == NULL) {
        return;
    }
    wg_links_free(&search->links);
    free(search->walk.before);
    free(search->walk.order);
    free(search->walk.skip);
    free(search->sources);
    free(search->chain);
    free(search->near);
    free(search->digits);
    free(search);
}
