// The exact position of a closed chain of cells relative to a pose.

#include <math.h>

#include "links.h"
#include "wide.h"

enum { MOST_COORDINATE = 20001 };

static const int64_t LONGEST = (int64_t)1 << 59;

// A pose and a distance from it, in multiples of 1/scale half cell.
typedef struct Around {
    int64_t scale;
    int64_t x;
    int64_t y;
    int64_t radius;  // -1 if it is not a multiple
    double rough_radius;
    bool is_doubtful;
} Around;

// Returns true if a piece (half cells) crosses the ray upwards from a pose.
static bool crosses(const Around *around, WgPiece piece)
{
    WgInt128 px = (WgInt128)piece.px * around->scale - around->x;
    WgInt128 qx = (WgInt128)piece.qx * around->scale - around->x;
    if ((px <= 0) == (qx <= 0)) {
        return false;
    }
    WgInt128 py = (WgInt128)piece.py * around->scale - around->y;
    WgInt128 above = py * (piece.qx - piece.px) - px * (piece.qy - piece.py);
    return above != 0 && (above > 0) == (piece.qx > piece.px);
}

// Compares two lengths as floats: 1 if the first is certainly longer, -1 if it is certainly
// shorter, else 0.
static int compare_roughly(double one, double two)
{
    double doubt = 1e-10 * (one + two);
    return one > two + doubt ? 1 : (one < two - doubt ? -1 : 0);
}

// Returns true if a corner is farther from a pose than the radius.
static bool is_beyond(Around *around, int64_t x, int64_t y)
{
    WgInt128 dx = (WgInt128)x * around->scale - around->x;
    WgInt128 dy = (WgInt128)y * around->scale - around->y;
    WgUint128 square = (WgUint128)(dx * dx + dy * dy);
    int roughly = compare_roughly(sqrt((double)square), around->rough_radius);
    if (roughly == 0 && around->radius < 0) {
        around->is_doubtful = true;
        return false;
    }
    return roughly != 0 ? roughly > 0 : square > (WgUint128)around->radius * (WgUint128)around->radius;
}

// Returns true if a piece is farther from a pose than the radius.
static bool is_away(Around *around, WgPiece piece)
{
    int64_t ex = piece.qx - piece.px;
    int64_t ey = piece.qy - piece.py;
    int64_t length_sq = ex * ex + ey * ey;
    WgInt128 ux = around->x - (WgInt128)piece.px * around->scale;
    WgInt128 uy = around->y - (WgInt128)piece.py * around->scale;
    WgInt128 along = ex * ux + ey * uy;
    if (along <= 0 || along >= (WgInt128)length_sq * around->scale) {
        return is_beyond(around, piece.px, piece.py) && is_beyond(around, piece.qx, piece.qy);
    }
    WgUint128 side = wg_magnitude(ex * uy - ey * ux);
    int roughly = compare_roughly((double)side / sqrt((double)length_sq), around->rough_radius);
    if (roughly != 0) {
        return roughly > 0;
    }
    if (around->radius < 0) {
        around->is_doubtful = true;
        return false;
    }
    WgWide apart = wg_wide_of(side);
    apart = wg_wide_times(&apart, side);
    WgWide least = wg_wide_of((WgUint128)around->radius * (WgUint128)around->radius);
    least = wg_wide_times(&least, (WgUint128)length_sq);
    return wg_wide_compare(&apart, &least) > 0;
}

WgStatus wg_chain_around(const int64_t *cells, int64_t count, int64_t scale, int64_t x, int64_t y, int64_t radius,
                         double rough_radius, int64_t *winds, int64_t *away)
{
    bool sane = count >= 1 && scale >= 1 && scale < LONGEST / (2 * MOST_COORDINATE + 1) && wg_abs(x) < LONGEST &&
                wg_abs(y) < LONGEST && radius >= -1 && radius < LONGEST && rough_radius >= 0.0;
    for (int64_t i = 0; i < 2 * count && sane; i++) {
        sane = cells[i] >= -2 && cells[i] <= MOST_COORDINATE;
    }
    if (!sane) {
        return WG_BAD_VALUE;
    }
    Around around = {scale, x, y, radius, rough_radius, false};
    bool odd = false;
    bool far = true;
    for (int64_t i = 0; i < count; i++) {
        int64_t next = i + 1 == count ? 0 : i + 1;
        WgPiece line[3];
        wg_link_line(cells[2 * i], cells[2 * i + 1], cells[2 * next], cells[2 * next + 1], line);
        for (int part = 0; part < 3; part++) {
            odd = odd != crosses(&around, line[part]);
            far = far && rough_radius < INFINITY && is_away(&around, line[part]);
        }
    }
    *winds = odd;
    *away = around.is_doubtful ? -1 : far;
    return WG_OK;
}

int64_t wg_chain_gap_sq(const int64_t *cells, int64_t count)
{
    int64_t widest = 0;
    for (int64_t i = 0; i < count; i++) {
        int64_t next = i + 1 == count ? 0 : i + 1;
        int64_t dx = wg_max(wg_abs(cells[2 * next] - cells[2 * i]) - 1, 0);
        int64_t dy = wg_max(wg_abs(cells[2 * next + 1] - cells[2 * i + 1]) - 1, 0);
        widest = wg_max(widest, dx * dx + dy * dy);
    }
    return widest;
}
