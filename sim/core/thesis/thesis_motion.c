// The thesis's motion: forward in steps of one pixel until it touches something,
// with its three faults.
//
// It slides along a wall after looking at only one cell, backs off without looking, and continues
// if only the corner of a cell is touched; so a robot that turns often works its way into walls and
// through them. Each fault can be repaired; with all three repaired, the disc is only ever at
// places that were found to be clear.
//
// Source: the thesis's listing, simGuiExp.checkCollision and advanceRobot; the disc test is Java's
// Ellipse2D.intersects.

#include "thesis_parts.h"

static const double MOST_OPEN = 60.0;  // px: side of the largest box that is checked before a move

// The obstacle in the path of a one-pixel step: none; a wall that one of the two single-axis moves,
// or both, would touch too; or only the corner of a cell. TOUCH_BOTH is the sum of the two before
// it.
enum { TOUCH_NOTHING = 0, TOUCH_X = 1, TOUCH_Y = 2, TOUCH_BOTH = 3, TOUCH_CORNER = 4 };

// Distance along one axis from the disc's centre to a cell, in the ellipse's own coordinates, where
// its radius is 1/2.
static inline double near_on_axis(double place, double radius, int64_t cell)
{
    double width = radius * 2.0;
    double low = ((double)cell * THESIS_CELL - (place - radius)) / width - 0.5;
    double high = low + THESIS_CELL / width;
    if (low > 0.0) {
        return low;
    }
    return high < 0.0 ? high : 0.0;
}

// Returns true if the open disc meets the cell.
static inline bool touches_cell(ThesisPoint centre, double radius, int64_t cell_x, int64_t cell_y)
{
    double near_x = near_on_axis(centre.x, radius, cell_x);
    double near_y = near_on_axis(centre.y, radius, cell_y);
    return near_x * near_x + near_y * near_y < 0.25;
}

// Returns what a step of one pixel hits: the first wall that a single-axis part of it touches.
//
// Rows outside the grid are skipped, where the listing leaves its loop: the same inside a border of
// walls.
static int contact(const ThesisGrid *grid, ThesisPoint next, ThesisPoint here, double radius)
{
    bool beyond = next.x >= (double)grid->width * THESIS_CELL - radius ||
                  next.y >= (double)grid->height * THESIS_CELL - radius;
    int64_t centre_x = thesis_cell_of(next.x);
    int64_t centre_y = thesis_cell_of(next.y);
    int64_t left = wg_most(centre_x - THESIS_REACH, 0);
    int64_t right = wg_least(centre_x + THESIS_REACH, grid->width - 1);
    int64_t up = wg_most(centre_y - THESIS_REACH, 0);
    int64_t down = wg_least(centre_y + THESIS_REACH, grid->height - 1);
    int found = TOUCH_NOTHING;
    for (int64_t cell_y = down; cell_y >= up; cell_y--) {
        for (int64_t cell_x = left; cell_x <= right; cell_x++) {
            bool wall = thesis_value(grid, cell_x, cell_y) == WG_THESIS_WALL &&
                        touches_cell(next, radius, cell_x, cell_y);
            if (!beyond && !wall) {
                continue;
            }
            ThesisPoint along_x = {next.x, here.y};
            ThesisPoint along_y = {here.x, next.y};
            int touched = touches_cell(along_x, radius, cell_x, cell_y) ? TOUCH_X : TOUCH_NOTHING;
            touched += touches_cell(along_y, radius, cell_x, cell_y) ? TOUCH_Y : TOUCH_NOTHING;
            if (touched != TOUCH_NOTHING) {
                return touched;
            }
            if (wall) {
                found = TOUCH_CORNER;
            }
        }
    }
    return found;
}

// Returns true if the disc touches no wall.
static bool is_clear(const ThesisGrid *grid, ThesisPoint centre, double radius)
{
    int64_t centre_x = thesis_cell_of(centre.x);
    int64_t centre_y = thesis_cell_of(centre.y);
    int64_t last_x = wg_least(centre_x + THESIS_REACH, grid->width - 1);
    int64_t last_y = wg_least(centre_y + THESIS_REACH, grid->height - 1);
    for (int64_t cell_y = wg_most(centre_y - THESIS_REACH, 0); cell_y <= last_y; cell_y++) {
        for (int64_t cell_x = wg_most(centre_x - THESIS_REACH, 0); cell_x <= last_x; cell_x++) {
            if (thesis_value(grid, cell_x, cell_y) == WG_THESIS_WALL &&
                touches_cell(centre, radius, cell_x, cell_y)) {
                return false;
            }
        }
    }
    return true;
}

// Returns true if a move hits no wall and no edge of the grid, judged by the box around it. Then
// none of its steps needs a check, and a tick of the recorded vectors takes 59 ns instead of 68.
static bool is_open(const ThesisGrid *grid, ThesisPoint start, ThesisPoint path, double radius)
{
    const double margin = 0.5;  // px, far more than the rounding errors of such a move add up to
    double around = radius + margin;
    double low_x = (path.x < 0.0 ? start.x + path.x : start.x) - around;
    double low_y = (path.y < 0.0 ? start.y + path.y : start.y) - around;
    double high_x = (path.x > 0.0 ? start.x + path.x : start.x) + around;
    double high_y = (path.y > 0.0 ? start.y + path.y : start.y) + around;
    bool inside = low_x >= 0.0 && low_y >= 0.0 && high_x < (double)grid->width * THESIS_CELL &&
                  high_y < (double)grid->height * THESIS_CELL;
    if (!inside || high_x - low_x > MOST_OPEN || high_y - low_y > MOST_OPEN) {
        return false;
    }
    int64_t first_y = thesis_cell_of(low_y);
    int64_t last_x = thesis_cell_of(high_x);
    int64_t last_y = thesis_cell_of(high_y);
    for (int64_t cell_x = thesis_cell_of(low_x); cell_x <= last_x; cell_x++) {
        for (int64_t cell_y = first_y; cell_y <= last_y; cell_y++) {
            if (thesis_value(grid, cell_x, cell_y) == WG_THESIS_WALL) {
                return false;
            }
        }
    }
    return true;
}

// Sets the centre after a pixel's step that meets a wall, and returns WG_SLIDE or WG_BACK_OFF.
//
// A slide continues along one axis, and moves back along the other by one pixel's share.
static int64_t meet_wall(const ThesisGrid *grid, ThesisPoint *here, ThesisPoint next,
                         ThesisPoint unit, double radius, int touched, int64_t repairs,
                         double wall_friction)
{
    ThesisPoint back = {here->x - unit.x, here->y - unit.y};
    if (touched != TOUCH_BOTH) {
        ThesisPoint slid = back;
        if (touched == TOUCH_Y) {
            slid.x = wall_friction == 0.0 ? next.x : here->x + (1.0 - wall_friction) * unit.x;
        } else {
            slid.y = wall_friction == 0.0 ? next.y : here->y + (1.0 - wall_friction) * unit.y;
        }
        if ((repairs & WG_REPAIR_SLIDE) == 0 || is_clear(grid, slid, radius)) {
            *here = slid;
            return WG_SLIDE;
        }
    }
    if ((repairs & WG_REPAIR_BACK_OFF) == 0) {
        *here = back;
    }
    return WG_BACK_OFF;
}

WgThesisMove thesis_advance(const ThesisGrid *grid, double x, double y, double goal_x,
                            double goal_y, double radius, int64_t repairs, double wall_friction)
{
    ThesisPoint path = {goal_x - x, goal_y - y};
    double length = sqrt(path.x * path.x + path.y * path.y);
    ThesisPoint here = {x, y};
    ThesisPoint before = here;
    bool collision = false;
    int64_t ending = WG_STRAIGHT;

    // The listing divides by a length of zero and compares with NaN, so nothing moves.
    if (length != 0.0) {
        ThesisPoint unit = {1.0 / length * path.x, 1.0 / length * path.y};
        bool open = is_open(grid, here, path, radius);
        ThesisPoint gone = unit;
        ThesisPoint next = {x + gone.x, y + gone.y};
        while (fabs(gone.x) < fabs(path.x) || fabs(gone.y) < fabs(path.y)) {
            int touched = open ? TOUCH_NOTHING : contact(grid, next, here, radius);
            if (touched == TOUCH_CORNER) {
                ending = WG_CORNER;
                if ((repairs & WG_REPAIR_CORNER) != 0) {
                    touched = TOUCH_BOTH;
                }
            }
            if (touched != TOUCH_NOTHING && touched != TOUCH_CORNER) {
                before = here;
                ending =
                    meet_wall(grid, &here, next, unit, radius, touched, repairs, wall_friction);
                collision = true;
                break;
            }
            // As in the listing, the sum of the steps so far is added to the start, because its
            // rounding decides where steps end.
            gone.x += unit.x;
            gone.y += unit.y;
            here = next;
            next.x = x + gone.x;
            next.y = y + gone.y;
        }
    }
    thesis_clamp(grid, radius, &here.x, &here.y);
    if (!collision) {
        before = here;
    }
    const WgThesisMove move = {here.x, here.y, collision, ending, before.x, before.y};
    return move;
}

WgStatus wg_thesis_move(const int32_t *cells, int64_t width, int64_t height,
                        const WgThesisSettings *settings, double x, double y, double goal_x,
                        double goal_y, WgThesisMove *move)
{
    const double farthest = 1e6; // px; a tick moves at most 10,000
    if (!thesis_fits(width, height, settings->radius, x, y) ||
        !(fabs(goal_x - x) <= farthest && fabs(goal_y - y) <= farthest)) {
        return WG_BAD_VALUE;
    }
    const ThesisGrid grid = {cells, width, height};
    *move = thesis_advance(&grid, x, y, goal_x, goal_y, settings->radius, settings->repairs,
                           settings->wall_friction);
    return WG_OK;
}
