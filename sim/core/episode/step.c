// The parts of a step that few steps need: walls and fire nearby, events, noise, digests and
// recordings.

#include "step.h"

static bool is_clear_of(const WgArena *arena, const WgSettings *settings, int cells, const WgState *state)
{
    return wg_robot_is_clear(wg_grid(arena), cells, arena->headings, settings, state->x, state->y, state->heading);
}

static WgFound first_cut(const WgArena *arena, const WgSettings *settings, int cells, WgSegment way, int64_t heading)
{
    return wg_robot_first_not_clear(wg_grid(arena), cells, arena->headings, settings, way, heading);
}

void wg_burn(WgRobot *robot, int64_t step, WgFound cell, int state)
{
    robot->report.ending = WG_BURNED;
    robot->report.hit_state = state;
    robot->report.hit_step = step;
    robot->report.hit_ix = cell.ix;
    robot->report.hit_iy = cell.iy;
}

int64_t wg_change_cells(const WgArena *arena, int64_t step, int64_t first)
{
    int64_t time = arena->events[first].time;
    int64_t next = first;
    while (next < arena->event_count) {
        const WgEvent *event = &arena->events[next];
        if (event->step != step || event->time != time) {
            break;
        }
        arena->cells[event->iy * arena->width + event->ix] = (uint8_t)event->state;
        wg_mark_near(wg_grid(arena), arena->near, event->ix, event->iy);
        next++;
    }
    return next;
}

void wg_catch(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot)
{
    const WgState *state = &robot->body->state;
    WgSegment here = {state->x, state->y, state->x, state->y};
    static const int CAUGHT[2] = {WG_SOLID, WG_BURNING};
    for (int k = 0; k < 2; k++) {
        if (!is_clear_of(arena, settings, CAUGHT[k], state)) {
            wg_burn(robot, step, first_cut(arena, settings, CAUGHT[k], here, state->heading), CAUGHT[k]);
            break;
        }
    }
}

// Returns true if the point that a body's pose is about is in the body.
static bool is_about_its_inside(const WgFootprint *footprint)
{
    for (int64_t k = 0; k < footprint->count; k++) {
        int64_t next = k + 1 < footprint->count ? k + 1 : 0;
        if (footprint->x[k] * footprint->y[next] < footprint->y[k] * footprint->x[next]) {
            return false;
        }
    }
    return true;
}

// Records walls that a piece of the path of an unsafe motion model cuts: deepest cut, first
// overlap, first tunnel.
static void judge_piece(const WgArena *arena, const WgSettings *settings, int64_t step, WgSegment way, WgRobot *robot)
{
    WgReport *report = &robot->report;
    int64_t reach = settings->reach;
    double radius = sqrt((double)settings->clear_sq);
    const WgFootprint *footprint = &settings->footprint;
    int64_t heading = robot->body->state.heading;
    // Only a point inside the robot can be said to go through a wall with it.
    bool may_tunnel = is_about_its_inside(footprint);
    int64_t low = wg_most(wg_cell_of(wg_least(way.py, way.qy) - reach), -1);
    int64_t high = wg_least(wg_cell_of(wg_most(way.py, way.qy) + reach), arena->height);
    int64_t left = wg_most(wg_cell_of(wg_least(way.px, way.qx) - reach), -1);
    int64_t right = wg_least(wg_cell_of(wg_most(way.px, way.qx) + reach), arena->width);
    for (int64_t iy = low; iy <= high; iy++) {
        for (int64_t ix = left; ix <= right; ix++) {
            if (wg_cell_state(wg_grid(arena), ix, iy) != WG_SOLID) {
                continue;
            }
            double depth = footprint->count > 0
                               ? wg_body_depth(arena->headings, footprint, way, heading, ix, iy)
                               : wg_segment_box_depth(radius, way, ix, iy);
            report->overlap = wg_higher(report->overlap, depth);
            if (depth > settings->tolerance && report->overlap_step < 0) {
                report->overlap_step = step;
                report->overlap_ix = ix;
                report->overlap_iy = iy;
            }
            if (report->ending == WG_LIMIT && may_tunnel && wg_segment_crosses_box(way, ix, iy)) {
                report->ending = WG_TUNNEL;
                report->hit_step = step;
                report->hit_ix = ix;
                report->hit_iy = iy;
            }
        }
    }
}

void wg_arrive_closely(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t x, int64_t y,
                       WgRobot *robot)
{
    WgSegment way = {robot->body->state.x, robot->body->state.y, x, y};
    if (arena->event_count > 0 && robot->report.ending == WG_LIMIT) {
        WgFound fire = first_cut(arena, settings, WG_BURNING, way, robot->body->state.heading);
        if (fire.found) {
            wg_burn(robot, step, fire, WG_BURNING);
        }
    }
    if (settings->motion != WG_SWEPT
        && first_cut(arena, settings, WG_SOLID, way, robot->body->state.heading).found) {
        judge_piece(arena, settings, step, way, robot);
    }
    wg_arrive(settings, x, y, robot);
}

// The share of a slide that is lost to a wall.
static double lost_to_wall(const WgSettings *settings)
{
    return settings->contact == WG_CONTACT_SLIDE ? settings->wall_friction : 1.0;
}

// Returns the solid cell that stops a robot: of those that cut its disc on a way, the one nearest to
// the place where it stops; for a body, the nearest to its sides.
static WgFound stopping_cell(const WgArena *arena, const WgSettings *settings, int64_t x, int64_t y, WgSegment way,
                             int64_t heading)
{
    enum { SLACK = 20 };  // lattice units that a robot may stop before a wall

    WgGrid grid = wg_grid(arena);
    double radius = sqrt((double)settings->clear_sq);
    int64_t reach = settings->reach + SLACK;
    int64_t nearest = reach * reach;
    WgFound found = {false, 0, 0};
    if (settings->footprint.count > 0) {
        found = wg_body_stopping_cell(grid, arena->headings, &settings->footprint, x, y, way, heading);
        return found.found ? found : first_cut(arena, settings, WG_SOLID, way, heading);
    }
    for (int64_t iy = wg_cell_of(y - reach); iy <= wg_cell_of(y + reach); iy++) {
        for (int64_t ix = wg_cell_of(x - reach); ix <= wg_cell_of(x + reach); ix++) {
            int64_t away = wg_point_box_distance_sq(x, y, ix, iy);
            // A wall that the robot drives along touches its disc, but does not cut it.
            if (away < nearest && wg_cell_state(grid, ix, iy) == WG_SOLID
                && wg_segment_box_depth(radius, way, ix, iy) > 1e-6) {
                nearest = away;
                found = (WgFound){true, ix, iy};
            }
        }
    }
    // A wall that the robot only grazes may be anywhere on the way.
    return found.found ? found : wg_first_not_clear(grid, WG_SOLID, wg_disc(settings), way);
}

// Ends the run if a wall has cut a move short that was to lead from p to q, and walls may not be
// touched.
static void judge_contact(const WgArena *arena, const WgSettings *settings, int64_t step, WgSegment way,
                          WgMoved moved, WgRobot *robot)
{
    WgReport *report = &robot->report;
    if (settings->contact != WG_CONTACT_FAIL || report->ending != WG_LIMIT || !wg_is_contact(moved.contact)) {
        return;
    }
    // A move that `endpoint` refuses is stopped by what is at its end.
    const WgState *state = &robot->body->state;
    WgFound cell = {false, 0, 0};
    if (settings->motion == WG_ENDPOINT && state->x == way.px && state->y == way.py) {
        cell = stopping_cell(arena, settings, way.qx, way.qy, (WgSegment){way.qx, way.qy, way.qx, way.qy},
                             state->heading);
    }
    if (!cell.found) {
        cell = stopping_cell(arena, settings, state->x, state->y, way, state->heading);
    }
    report->ending = WG_CONTACT;
    report->hit_step = step;
    report->hit_ix = cell.ix;
    report->hit_iy = cell.iy;
}

static WgMoved swept_move(const WgArena *arena, const WgSettings *settings, WgSegment way, double begin, double end,
                          const WgRobot *robot)
{
    if (settings->footprint.count > 0) {
        return wg_swept_body_move(wg_grid(arena), arena->headings, &settings->footprint, robot->body->state.heading,
                                  way, begin, end, lost_to_wall(settings), robot->chain, robot->corners);
    }
    return wg_swept_move(wg_grid(arena), wg_disc(settings), way, begin, end, lost_to_wall(settings), robot->chain,
                         robot->corners);
}

WgNormal wg_move_closely(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                          int64_t from, int64_t until, WgRobot *robot)
{
    const WgState *state = &robot->body->state;
    WgSegment way = {state->x, state->y, state->x + dx, state->y + dy};
    int64_t before = robot->corners;
    WgMoved moved;
    if (settings->motion == WG_SWEPT) {
        double begin = (double)from / (double)WG_STEP_TIME;
        double end = (double)until / (double)WG_STEP_TIME;
        moved = swept_move(arena, settings, way, begin, end, robot);
    } else if (settings->footprint.count > 0) {
        moved = wg_endpoint_body_move(wg_grid(arena), arena->headings, &settings->footprint, state->heading, way,
                                      robot->chain, before);
    } else {
        moved = wg_endpoint_move(wg_grid(arena), wg_disc(settings), way, robot->chain, before);
    }
    robot->corners = moved.count;

    // A robot that stands still may still be burnt, or be at the target.
    if (robot->corners == before) {
        wg_arrive_closely(arena, settings, step, state->x, state->y, robot);
    }
    for (int64_t k = before; k < robot->corners; k++) {
        wg_arrive_closely(arena, settings, step, robot->chain[k].x, robot->chain[k].y, robot);
    }
    judge_contact(arena, settings, step, way, moved, robot);
    return moved.contact;
}

WgNormal wg_touch(const WgArena *arena, const WgSettings *settings, int64_t step, WgSegment way, int64_t turn,
                  WgRobot *robot)
{
    WgState *state = &robot->body->state;
    int64_t before = state->heading;
    state->heading = wg_reduced_heading(before + turn);
    WgMoved moved = {robot->corners, {(double)(way.px - way.qx), (double)(way.py - way.qy)}};
    if (!wg_is_contact(moved.contact)) {
        // A move too short for the lattice.
        double side = state->speed < 0 ? 1.0 : -1.0;
        moved.contact.x = side * (double)arena->headings[state->heading];
        moved.contact.y = side * (double)arena->headings[wg_reduced_heading(state->heading - WG_TURN / 4)];
    }
    if (settings->motion == WG_SWEPT) {
        // Only what stops the move counts, so its corners are forgotten.
        moved = swept_move(arena, settings, way, 0.0, 0.0, robot);
    }
    judge_contact(arena, settings, step, way, moved, robot);
    state->heading = before;
    return moved.contact;
}

int64_t wg_share_of(int64_t whole, int64_t time, int64_t whole_time)
{
    return wg_round_away((double)whole * ((double)time / (double)whole_time));
}

WgNormal wg_move_through_events(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                                 int64_t from, int64_t end, WgRobot *robot)
{
    // `endpoint` checks the world only at the end of a step, so all events come first.
    bool exact = settings->motion == WG_SWEPT;
    WgNormal last = {0.0, 0.0};
    int64_t now = from;
    int64_t gone_x = 0;
    int64_t gone_y = 0;
    bool is_stopped = false;
    while (now < end) {
        bool due = robot->next_event < arena->event_count && arena->events[robot->next_event].step == step
                   && arena->events[robot->next_event].time < end;
        int64_t until = due && exact ? arena->events[robot->next_event].time : end;
        if (until > now && (exact || !due)) {
            int64_t there_x = until == end ? dx : wg_share_of(dx, until - from, end - from);
            int64_t there_y = until == end ? dy : wg_share_of(dy, until - from, end - from);
            if (is_stopped) {
                there_x = gone_x;
                there_y = gone_y;
            }
            WgNormal contact = wg_move(arena, settings, step, there_x - gone_x, there_y - gone_y, now, until, robot);

            // The robot waits for the next event.
            bool waits = robot->corners == 0 || robot->chain[robot->corners - 1].time < until;
            if (until < WG_STEP_TIME && waits) {
                wg_add_corner(robot, robot->body->state.x, robot->body->state.y, until);
            }
            if (contact.x != 0.0 || contact.y != 0.0) {
                last = contact;
                is_stopped = settings->contact != WG_CONTACT_SLIDE;
            }
            gone_x = there_x;
            gone_y = there_y;
            now = until;
        }
        if (due && robot->report.ending == WG_LIMIT) {
            robot->next_event = wg_change_cells(arena, step, robot->next_event);
            wg_catch(arena, settings, step, robot);
        }
        if (robot->report.ending != WG_LIMIT) {
            break;
        }
    }
    return last;
}

// Turns a body by a push: the shorter way, as far as it is clear.
static void push_around(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot)
{
    int64_t earlier = robot->carriage->bumped;
    int64_t shorter = wg_turn_towards(0, wg_reduced_heading(turn));
    (void)wg_turn_body(arena, settings, step, shorter, robot);
    WgNormal contact = wg_bump_of_turn(arena, robot->carriage);
    robot->carriage->bumped = earlier;  // a push's contact is sensed in this step
    if (wg_is_contact(contact)) {
        robot->contact = contact;
    }
}

// Displaces the robot by a push, as far as the path is clear, and turns it.
static void push(const WgArena *arena, const WgSettings *settings, int64_t step, const WgPush *by, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    if (settings->footprint.count > 0) {
        push_around(arena, settings, step, by->turn, robot);
    } else {
        state->heading = wg_reduced_heading(state->heading + by->turn);
    }
    bool stays = by->dx == 0 && by->dy == 0;
    // Under `endpoint` a robot may stand in a wall, and then it can never move,
    // because no path out is clear.
    if (stays || !is_clear_of(arena, settings, WG_SOLID, state)) {
        return;
    }

    // All of this takes no time and happens at the end of the step.
    int64_t before = robot->corners;
    WgSegment way = {state->x, state->y, state->x + by->dx, state->y + by->dy};
    WgMoved moved = swept_move(arena, settings, way, 1.0, 1.0, robot);
    robot->corners = moved.count;
    wg_note_headings(robot, before);
    if (wg_is_contact(moved.contact)) {
        robot->contact = moved.contact;
    }
    for (int64_t k = before; k < robot->corners && robot->report.ending == WG_LIMIT; k++) {
        wg_arrive_closely(arena, settings, step, robot->chain[k].x, robot->chain[k].y, robot);
    }
    judge_contact(arena, settings, step, way, moved, robot);
}

void wg_disturb(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot)
{
    // Apply the pushes at this time, in order.
    while (robot->next_push < settings->push_count && settings->pushes[robot->next_push].step <= step) {
        const WgPush *by = &settings->pushes[robot->next_push++];
        if (by->step == step && robot->report.ending == WG_LIMIT) {
            push(arena, settings, step, by, robot);
        }
    }

    // Apply the push at this place; if there are two, the first.
    int64_t ix = wg_cell_of(robot->body->state.x);
    int64_t iy = wg_cell_of(robot->body->state.y);
    for (int64_t k = 0; k < settings->place_count && robot->report.ending == WG_LIMIT; k++) {
        if (settings->pushes[k].ix == ix && settings->pushes[k].iy == iy) {
            push(arena, settings, step, &settings->pushes[k], robot);
            break;
        }
    }
}

void wg_count_wanted(WgRobot *robot)
{
    robot->report.cells_left--;
    if (robot->report.cells_left == 0 && robot->report.ending == WG_LIMIT) {
        robot->report.ending = WG_COVERED;
    }
}

int64_t wg_slipped(const WgSettings *settings, int64_t step, int64_t drive)
{
    double lost = settings->slip * wg_noise_draw(settings, wg_noise_channel(step, WG_NOISE_SLIP));
    return wg_whole_speed((double)drive * (1.0 - lost));
}

// Returns the factor by which a measured length or turn is too long.
static double wrong(const WgSettings *settings, int64_t step, int64_t channel)
{
    double draw = wg_noise_draw(settings, wg_noise_channel(step, channel));
    return 1.0 + settings->odometry_noise * (2.0 * draw - 1.0);
}

void wg_measure_move(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t dx, int64_t dy,
                     WgRobot *robot)
{
    int64_t turned = wg_floor(robot->odometry.heading + 0.5) - robot->body->state.heading;
    double along = (double)arena->headings[turned & (WG_TURN - 1)] / (double)(1 << 30);
    double across = (double)arena->headings[(turned - WG_TURN / 4) & (WG_TURN - 1)] / (double)(1 << 30);
    double scale = wrong(settings, step, WG_NOISE_WAY);
    robot->odometry.x += scale * (along * (double)dx - across * (double)dy);
    robot->odometry.y += scale * (across * (double)dx + along * (double)dy);
}

void wg_measure_turn(const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot)
{
    robot->odometry.heading += wrong(settings, step, WG_NOISE_TURN) * (double)turn;
}

void wg_take_answer(WgEpisode *episode)
{
    double *answer = episode->workspace.answer;
    if (answer[0] == 0.0) {
        return;
    }
    WgCommand *command = &episode->workspace.command;
    answer[0] = 0.0;
    command->speed = answer[1];
    command->turn_rate = answer[2];
    command->used_random = answer[3];
    size_t size = (size_t)episode->controller.memory_size * sizeof *answer;
    memcpy(episode->robot.body->memory, answer + WG_ANSWER, size);
}

// Returns how many numbers the flat array has.
static int64_t flat_size(const WgWorkspace *workspace)
{
    const WgObservation *seen = &workspace->observation;
    int64_t neighbours = workspace->neighbour_room * (WG_NEIGHBOUR_NUMBERS + seen->message_size);
    return WG_SENSES + seen->beam_count + neighbours + workspace->tail;
}

// Copies the neighbours into rows of a flat array; rows without one are NaN.
static void flatten_neighbours(const WgWorkspace *workspace, double *rows)
{
    const WgObservation *seen = &workspace->observation;
    int64_t width = WG_NEIGHBOUR_NUMBERS + seen->message_size;
    for (int64_t k = 0; k < workspace->neighbour_room; k++) {
        double *row = rows + k * width;
        for (int64_t n = 0; n < width; n++) {
            row[n] = NAN;
        }
        if (k < seen->neighbour_count) {
            memcpy(row, &seen->neighbours[k], (size_t)width * sizeof *row);
        }
    }
}

void wg_flatten(WgWorkspace *workspace)
{
    memcpy(workspace->flat, &workspace->observation, WG_SENSES * sizeof(double));
    int64_t beams = workspace->observation.beam_count;
    if (beams > 0) {
        memcpy(workspace->flat + WG_SENSES, workspace->beams, (size_t)beams * sizeof(double));
    }
    if (workspace->neighbour_room > 0) {
        flatten_neighbours(workspace, workspace->flat + WG_SENSES + beams);
    }
    if (workspace->tail > 0) {
        double *last = workspace->flat + flat_size(workspace) - 1;
        *last = workspace->observation.goal_heading;
        if (workspace->tail > 1) {
            last[-1] = workspace->observation.tilt_heading;
            last[-2] = workspace->observation.tilt;
        }
    }
}

void wg_act_flat(const WgController *controller, WgWorkspace *workspace, double *memory)
{
    // Anything that a controller writes into the observation is cleared after the step, because
    // otherwise it would be memory outside the state.
    wg_flatten(workspace);
    double command[3 + WG_MOST_MESSAGE] = {0.0};
    const WgObservation *seen = &workspace->observation;
    if (controller->flat(workspace->flat, flat_size(workspace), memory, controller->memory_size, command) != 0) {
        workspace->command.error = "the controller failed";
    }
    workspace->command.speed = command[0];
    workspace->command.turn_rate = command[1];
    workspace->command.used_random = command[2];
    if (workspace->command.message != NULL) {
        memcpy(workspace->command.message, command + 3, (size_t)seen->message_size * sizeof *command);
    }
}

static uint64_t hash(uint64_t digest, uint64_t word)
{
    return (digest ^ word) * WG_HASH_PRIME;
}

void wg_hash_step(WgRobot *robot, int64_t words, bool bumped)
{
    uint64_t digest = hash(robot->report.digest, bumped);
    for (int64_t k = 0; k < robot->corners; k++) {
        digest = hash(digest, (uint64_t)robot->chain[k].x);
        digest = hash(digest, (uint64_t)robot->chain[k].y);
        digest = hash(digest, (uint64_t)robot->chain[k].time);
    }
    for (int64_t k = 0; k < words; k++) {
        digest = hash(digest, wg_word(robot->body, k));
    }
    robot->report.digest = digest;
}

void wg_write_step(const WgRecording *recording, const WgRobot *robot, int64_t words, int64_t step, bool bumped)
{
    int64_t row = step - recording->first_step;
    if (row < 0 || row >= recording->row_count) {
        return;
    }
    int64_t *out = recording->rows + row * (words + 1);
    out[0] = bumped;
    memcpy(out + 1, robot->body, (size_t)words * sizeof *out);
    int64_t first = robot->report.points - robot->corners - recording->first_point;
    for (int64_t k = 0; k < robot->corners && first + k < recording->path_size; k++) {
        WgPathPoint *point = &recording->path[first + k];
        point->step = step;
        point->time = robot->chain[k].time;
        point->x = robot->chain[k].x;
        point->y = robot->chain[k].y;
        if (recording->path_headings != NULL) {
            recording->path_headings[first + k] = robot->chain_headings[k];
        }
    }
}
