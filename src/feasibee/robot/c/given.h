/* The settings of a robot from an array, for programs that simulate its body; not a part of feasibee.h.
 *
 * The numbers are those of numbers_of in robot/given.py, in their order; then come the strategy's parameters. */

enum feasibee_given {
    GIVEN_EXPLORATION, GIVEN_GAIN, GIVEN_DISSEMINATION_FLOOR, GIVEN_QUALITY_FLOOR, GIVEN_LISTENS_FOR,
    GIVEN_INBOX_SIZE, GIVEN_OWN_VOTE, GIVEN_RANDOM_TIES, GIVEN_FIRST_SIGHT, GIVEN_EVERY_MESSAGE, GIVEN_ROUNDS,
    GIVEN_HEARD, GIVEN_QUORUM, GIVEN_QUORUM_OF,
    GIVEN_ROBOTS, GIVEN_COUNT, GIVEN_TASKS, GIVEN_ROBOT_IDS, GIVEN_TASK_IDS, GIVEN_ROBOT_CLASSES, GIVEN_TASK_CLASSES,
    GIVEN_ID_BITS, GIVEN_KNOWS_COUNT, GIVEN_WIDTH, GIVEN_HEIGHT, GIVEN_WALLED, GIVEN_SIGHT, GIVEN_RADIO,
    GIVEN_SPEED, GIVEN_DISSEMINATION, GIVEN_MEAN_RUN, GIVEN_FLOODING, GIVEN_DELAY, GIVEN_COLUMNS, GIVEN_WORK,
    GIVEN_CHARGE,
    GIVEN_PARAMETERS
};

/* Read the numbers on which knowledge may depend; the cells of the plan are the program's. */
static struct feasibee_setting feasibee_setting_given(const double *numbers)
{
    struct feasibee_setting setting = {
        .robots = (int16_t)numbers[GIVEN_ROBOTS], .count = (int16_t)numbers[GIVEN_COUNT],
        .tasks = (int16_t)numbers[GIVEN_TASKS], .robot_ids = (int16_t)numbers[GIVEN_ROBOT_IDS],
        .task_ids = (int16_t)numbers[GIVEN_TASK_IDS], .robot_classes = (uint8_t)numbers[GIVEN_ROBOT_CLASSES],
        .task_classes = (uint8_t)numbers[GIVEN_TASK_CLASSES], .id_bits = (uint8_t)numbers[GIVEN_ID_BITS],
        .knows_count = numbers[GIVEN_KNOWS_COUNT] != 0.0, .walled = numbers[GIVEN_WALLED] != 0.0,
        .width = numbers[GIVEN_WIDTH], .height = numbers[GIVEN_HEIGHT], .sight = numbers[GIVEN_SIGHT],
        .radio = numbers[GIVEN_RADIO], .speed = numbers[GIVEN_SPEED], .exploration = numbers[GIVEN_EXPLORATION],
        .dissemination = numbers[GIVEN_DISSEMINATION], .mean_run = numbers[GIVEN_MEAN_RUN],
        .flooding = numbers[GIVEN_FLOODING], .delay = numbers[GIVEN_DELAY],
        .columns = (int16_t)numbers[GIVEN_COLUMNS],
        .work = numbers[GIVEN_WORK], .charge = numbers[GIVEN_CHARGE],
    };
    for (int k = 0; k < FEASIBEE_PARAMETERS; k++)
        setting.parameters[k] = numbers[GIVEN_PARAMETERS + k];
    return setting;
}

/* Read what a scenario sets for a robot with a strategy; the draws are the program's. */
static struct feasibee_settings feasibee_settings_given(const double *numbers,
                                                        const struct feasibee_strategy *strategy,
                                                        const struct feasibee_setting *setting)
{
    struct feasibee_settings settings = feasibee_defaults(strategy);
    settings.exploration = numbers[GIVEN_EXPLORATION];
    settings.gain = numbers[GIVEN_GAIN];
    settings.dissemination_floor = (uint16_t)numbers[GIVEN_DISSEMINATION_FLOOR];
    settings.quality_floor = (uint16_t)numbers[GIVEN_QUALITY_FLOOR];
    settings.listens_for = (int32_t)numbers[GIVEN_LISTENS_FOR];
    settings.inbox_size = (uint16_t)numbers[GIVEN_INBOX_SIZE];
    settings.own_vote = numbers[GIVEN_OWN_VOTE] != 0.0;
    settings.random_ties = numbers[GIVEN_RANDOM_TIES] != 0.0;
    settings.first_sight = numbers[GIVEN_FIRST_SIGHT] != 0.0;
    settings.every_message = numbers[GIVEN_EVERY_MESSAGE] != 0.0;
    settings.declare.rounds = (uint16_t)numbers[GIVEN_ROUNDS];
    settings.declare.heard = (uint16_t)numbers[GIVEN_HEARD];
    settings.declare.quorum = (uint16_t)numbers[GIVEN_QUORUM];
    settings.declare.quorum_of = (uint16_t)numbers[GIVEN_QUORUM_OF];
    settings.setting = setting;
    return settings;
}
