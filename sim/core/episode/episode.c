// The loop of an episode: step by step, until the outcome is decided.

#include "step.h"
#include "stopwatch.h"

// Judges and records a finished step; returns true if it was the last one.
static bool finish_step(WgEpisode *episode)
{
    int64_t step = episode->step;
    const WgSettings *settings = episode->settings;
    wg_note_step(settings, &episode->recording, episode->search.words, step, &episode->robot);
    return wg_is_over(settings, &episode->search, step, episode->quiet, &episode->robot) || step >= settings->steps;
}

WgStatus wg_episode_record(WgEpisode *episode, int64_t *rows, int64_t row_count, WgPathPoint *path,
                           int64_t *path_headings, int64_t path_size)
{
    if (row_count < 0 || path_size < 0) {
        return WG_BAD_SIZE;
    }
    WgRecording *recording = &episode->recording;
    recording->rows = rows;
    recording->row_count = row_count;
    recording->first_step = episode->step + 1;
    recording->path = path;
    recording->path_headings = path_headings;
    recording->path_size = path_size;
    recording->first_point = episode->robot.report.points;
    return WG_OK;
}

// Runs up to a step, with every feature that a run can have. Returns true if it continues.
static bool run_any(WgEpisode *episode, int64_t last)
{
    const WgSettings *settings = episode->settings;
    for (int64_t step = episode->step + 1; step <= last; step++) {
        episode->step = step;
        if (wg_move_and_sense(episode->arena, settings, &episode->robot, &episode->workspace, step)
            && !wg_act(episode->arena, settings, &episode->controller, &episode->workspace, step, &episode->robot)) {
            return false;
        }
        if (finish_step(episode)) {
            return false;
        }
    }
    return true;
}

int64_t wg_episode_run(WgEpisode *episode, int64_t most_steps)
{
    const WgSettings *settings = episode->settings;
    int64_t last = wg_least(settings->steps, episode->step + most_steps);
    if (episode->over != 0) {
        return WG_OVER;
    }
    bool is_plain = wg_is_plain(episode);
    bool goes_on = true;
    WgStopwatch watch = wg_stopwatch();
    while (goes_on && episode->step < last) {
        int64_t until = wg_least(last, episode->step + watch.portion);
        goes_on = is_plain ? wg_run_plain(episode, until) : run_any(episode, until);
        if (wg_is_late(&watch)) {
            break;
        }
    }
    episode->over = !goes_on || episode->step >= settings->steps;
    return episode->over != 0 ? WG_OVER : WG_GOES_ON;
}

int64_t wg_episode_step(WgEpisode *episode)
{
    const WgSettings *settings = episode->settings;
    if (episode->over != 0) {
        return WG_OVER;
    }
    if (episode->waits != 0) {
        episode->waits = 0;
        wg_take_answer(episode);
        wg_apply_command(episode->arena, settings, &episode->workspace.command, episode->step, &episode->robot);
        episode->over = finish_step(episode);
    }
    while (episode->over == 0 && episode->step < settings->steps) {
        episode->step++;
        if (wg_move_and_sense(episode->arena, settings, &episode->robot, &episode->workspace, episode->step)) {
            wg_flatten(&episode->workspace);
            episode->waits = 1;
            return WG_ACTS;
        }
        episode->over = finish_step(episode);
    }
    episode->over = 1;
    return WG_OVER;
}

int64_t wg_episode_entry(const WgEpisode *episode)
{
    const WgReport *report = &episode->robot.report;
    if (report->ending != WG_LOOP) {
        return -1;
    }
    if (episode->settings->find_loop == WG_PROVE_LOOP) {
        return report->steps - report->period;
    }
    return wg_entry_of_loop(episode->search.log, episode->quiet, report->steps, report->period);
}
